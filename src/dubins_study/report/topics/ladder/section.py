"""The section on the ladder of margins toward a turning circle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.axes import power
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import ABSENT, count, digits, sentences
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import WIDE, Style, new_figure
from dubins_study.report.elements.topic import Topic
from dubins_study.report.topics.ladder import numbers
from dubins_study.report.topics.ladder.figures import legend_entries, plot_ladder

_ARRIVES = -6  # the check's default tolerance of misses: 1e-6 R


def ladder_section(results: Results) -> Section | None:
    """Matrix of solvers and margins, the margins down to which each is right, and why."""
    attempts = numbers.rungs(results.rows)
    if attempts.empty:
        return None
    table, names = numbers.ladder(attempts), Palette.of_page(results).names(attempts["solver"])
    named = attempts.assign(solver=attempts["solver"].map(names))
    text = (
        "Targets at margins of 1e-1 to 1e-12 R from a turning circle, on both sides of its front "
        "half, across which the shortest length jumps, and of its rear half, across which it does "
        "not."
    )
    text = sentences(text, _short_by_miss(named), _verdicts(named), _other_sides(named))
    blocks: list[Picture | Table] = [_picture(table, names), _table(numbers.down_to(table))]
    lead = (
        "Follow a solver's line to the right, toward the circle: where its mark changes, a margin "
        "has become too small for it."
    )
    return Section("ladder", "The ladder toward a turning circle", text, tuple(blocks), lead)


def _short_by_miss(attempts: pd.DataFrame) -> str:
    inner = attempts[attempts["side"] == numbers.JUMP]
    if inner.empty:
        return ""
    short = numbers.first_short_rung(inner)
    others = [solver for solver, right in numbers.right_everywhere(inner).items() if right]
    if short.empty:
        sentence = "Just inside the front half no solver trades a miss for the short path"
    else:
        items = ", ".join(f"{solver} from {_margin(10.0**rung)}" for solver, rung in short.items())
        sentence = (
            "Just inside the front half a small miss buys a path shorter by up to a full turn, "
            f"and these take it: {items}"
        )
    return f"{sentence}; the right path at every margin there: {', '.join(others) or 'none'}."


def _verdicts(attempts: pd.DataFrame) -> str:
    short = attempts[attempts["finding"] == "by its miss"]
    false = int(attempts["false_claim"].sum())
    claims = f"Of all {count(len(attempts))} claims {count(false)} are false"
    if short.empty:
        return f"{claims}."
    return (
        f"Those {count(len(short))} answers miss by {digits(2)(short['miss'].max())} R at most, "
        "and the check, whose reference is the least length over the miss made, calls them "
        f"optimal. {claims}."
    )


def _other_sides(attempts: pd.DataFrame) -> str:
    others = attempts[attempts["side"] != numbers.JUMP]
    if others.empty:
        return ""
    right = numbers.right_everywhere(others)
    wrong = [solver for solver, everywhere in right.items() if not everywhere]
    sentence = (
        f"On the other sides {count(sum(right.values()))} of {count(len(right))} solvers find the "
        "shortest path, coarse or not, at every margin"
    )
    return f"{sentence}, not {', '.join(wrong)}." if wrong else f"{sentence}."


def _margin(value: float) -> str:
    return f"1e{round(math.log10(value))}"


_CAPTION = (
    "Both sides of both halves of the circle: the worst of the answers at a margin. Right: the "
    "shortest path. Coarse: its shape, but longer than the check's tolerance allows. By its miss: "
    "optimal for the point that it ends at, and shorter than any path to the target. Dotted: the "
    f"largest miss that counts as arriving, {power(10.0**_ARRIVES)} R."
)


def _picture(table: pd.DataFrame, names: Mapping[str, str]) -> Picture:
    """One panel per side of the circle, side by side, the solvers' names on the left."""
    solvers = list(dict.fromkeys(table["solver"]))
    sides = [side for side in numbers.SIDES if (table["side"] == side).any()]
    figure = new_figure(WIDE, min(1.25 + 0.19 * len(solvers), 6.5))
    panels = figure.subplots(1, len(sides), sharey=True, squeeze=False)[0]
    for ax, side in zip(panels, sides, strict=True):
        plot_ladder(ax, table[table["side"] == side], solvers, names, _ARRIVES)
        ax.set_title(side)
        ax.tick_params(axis="y", labelleft=ax is panels[0])
    tight: Style = {"ncols": 6, "handletextpad": 0.2, "columnspacing": 1.2}
    figure.legend(handles=legend_entries(table), loc="outside lower left", **tight)
    alt = "Matrix of solvers and margins, a panel per side of the circle"
    return Picture("ladder", _CAPTION, figure, alt)


def _table(reach: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, attempts="attempts"),
        *(Column(side, side, _reach) for side in numbers.SIDES),
        *columns(
            count, by_miss="rungs by its miss", coarse="rungs coarse", false_claims="false claims"
        ),
    )
    caption = (
        "The least margin (R) down to which every answer is the shortest path, coarse or not; "
        "all: at every margin asked for; –: not at the widest."
    )
    return Table("ladder", caption, reach, shown)


def _reach(value: Any) -> str:
    number = float(value)
    return "all" if number == 0 else _margin(number) if number > 0 else ABSENT


TOPIC = Topic("the ladder toward a circle", ladder_section, "ladder")
