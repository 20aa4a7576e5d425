"""The section on the ladder of margins toward a turning circle."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.axes import power
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import ABSENT, count, digits, sentences
from dubins_study.report.elements.style import Style
from dubins_study.report.topics.ladder import numbers
from dubins_study.report.topics.ladder.figures import legend_entries, plot_ladder

_ARRIVES = -6  # the check's default tolerance of misses: 1e-6 R


def ladder_section(results: Results) -> Section | None:
    """Matrix of solvers and margins, the margins down to which each is right, and why."""
    attempts = numbers.rungs(results.rows)
    if attempts.empty:
        return None
    table = numbers.ladder(attempts)
    text = (
        "Targets at margins of 1e-1 to 1e-12 R from a turning circle, on both sides of its front "
        "half, across which the shortest length jumps, and of its rear half, across which it does "
        "not."
    )
    text = sentences(text, _short_by_miss(attempts), _verdicts(attempts), _other_sides(attempts))
    blocks: list[Picture | Table] = [*_pictures(table), _table(numbers.down_to(table))]
    return Section("ladder", "The ladder toward a turning circle", text, tuple(blocks))


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


_FINDINGS_CAPTION = (
    " Right: the shortest path. Coarse: its shape, but longer than the check's tolerance allows. "
    "By its miss: optimal for the point that it ends at, and shorter than any path to the target. "
    f"Dotted: the largest miss that counts as arriving, {power(10.0**_ARRIVES)} R."
)


def _pictures(table: pd.DataFrame) -> list[Picture]:
    solvers = list(dict.fromkeys(table["solver"]))
    pictures: list[Picture] = []
    tight: Style = {"ncols": 3, "handletextpad": 0.2, "columnspacing": 1.0}
    for side in numbers.SIDES:
        group = table[table["side"] == side]
        if group.empty:
            continue
        caption = f"{side[:1].upper()}{side[1:]} the circle: the worst of the answers at a margin."
        drawn = picture(
            f"ladder-{side.replace(', ', '-')}",
            plot_ladder,
            *(group, solvers, _ARRIVES),
            caption=caption if pictures else caption + _FINDINGS_CAPTION,
            alt=f"Matrix of solvers and margins, {side}",
            height=1.5 + 0.23 * len(solvers),
        )
        drawn.figure.legend(handles=legend_entries(group), loc="outside lower left", **tight)
        pictures.append(drawn)
    return pictures


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
