"""The section on the ladder of margins toward a turning circle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from dubins_study.report.data.results import Results
from dubins_study.report.elements.axes import mark_limit, only_grid, power
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import ABSENT, count, digits, sentences
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import (
    BLUE,
    INK,
    ORANGE,
    VERMILION,
    WIDE,
    Style,
    new_figure,
)
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import FloatArray
from dubins_study.study.tolerances import ARRIVES

SIDES = ("front, inside", "front, outside", "rear, inside", "rear, outside")
JUMP = "front, inside"  # here the length is up to 2 pi R above that on the circle's other side
# Results of an attempt, the best first.
FINDINGS = ("right", "coarse", "by its miss", "wrong basin", "no path")
ANSWERED = ("right", "coarse")  # the shortest path, accurate or not
SHORTER = 1e-4  # relative; an answer that is shorter than the optimum by this profits from its miss


def rungs(rows: pd.DataFrame) -> pd.DataFrame:
    """Every attempt with its place on the ladder and its finding.

    `right`: optimal, and as long as the scenario's shortest path. `by its miss`: the check accepts
    it as optimal, since it relaxes the reference over the miss, but it is shorter than the
    scenario's shortest path. `coarse`: longer, but with the same shape. `wrong basin`: longer, with
    another shape. `no path`: no path was returned, or it does not arrive.

    Returns:
        Columns solver, scenario_id, side, rung (margin as a power of ten), finding, false_claim,
        miss (radii).
    """
    group = rows[(rows["branch"] == "best") & (rows["margin"] > 0)]
    cos, sin = np.cos(group["heading"]), np.sin(group["heading"])
    ahead = (group["target_x"] - group["x"]) * cos + (group["target_y"] - group["y"]) * sin
    half = np.where(ahead > 0, "front", "rear")
    inside = np.where(group["region"].str.endswith("disc"), "inside", "outside")
    return pd.DataFrame(
        {
            "solver": group["solver"],
            "scenario_id": group["scenario_id"],
            "side": [f"{a}, {b}" for a, b in zip(half, inside, strict=True)],
            "rung": np.round(np.log10(group["margin"])).astype("int64"),
            "finding": _findings(group),
            "false_claim": group["false_claim"].astype(bool),
            "miss": group["miss"] / group["radius"],
        }
    )


def _findings(rows: pd.DataFrame) -> list[str]:
    optimal = (rows["verdict"] == "optimal").to_numpy()
    longer = (rows["verdict"] == "longer").to_numpy()
    basin = rows["wrong_basin"].to_numpy(dtype=np.bool_)
    least = rows["reference_low"].fillna(0.0).to_numpy(dtype=np.float64)
    length: FloatArray = rows["length"].to_numpy(dtype=np.float64)
    short = length < least * (1 - SHORTER)
    chosen = np.select(
        [optimal & ~short, longer & ~basin, optimal & short, longer],
        FINDINGS[:4],
        default=FINDINGS[4],
    )
    return [str(finding) for finding in chosen]


def ladder(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, side and rung, from the attempts that `rungs` returns.

    Columns solver, side, rung, attempts, finding (the worst one), false_claims.
    """
    place = {finding: i for i, finding in enumerate(FINDINGS)}
    grouped = attempts.assign(place=attempts["finding"].map(place)).groupby(
        ["solver", "side", "rung"], sort=False
    )
    frame = grouped.agg(
        attempts=("place", "size"), worst=("place", "max"), false_claims=("false_claim", "sum")
    ).reset_index()
    return frame.assign(finding=frame["worst"].map(dict(enumerate(FINDINGS)))).drop(columns="worst")


def down_to(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, from the table that `ladder` returns.

    Columns solver; per side the smallest margin such that at this margin and all wider ones every
    answer is the shortest path, coarse or not (0 if this holds for all margins, NaN if it does not
    hold at the widest); attempts; coarse and by_miss (numbers of rungs on the inner side of the
    jump); false_claims.
    """
    records = []
    for solver in solver_order(table["solver"].tolist()):
        group = table[table["solver"] == solver]
        record: dict[str, object] = {"solver": solver, "attempts": int(group["attempts"].sum())}
        for side in SIDES:
            record[side] = _least(group[group["side"] == side].sort_values("rung", ascending=False))
        inner = group[group["side"] == JUMP]
        record["by_miss"] = int((inner["finding"] == "by its miss").sum())
        record["coarse"] = int((group["finding"] == "coarse").sum())
        record["false_claims"] = int(group["false_claims"].sum())
        records.append(record)
    return pd.DataFrame.from_records(records)


def _least(ladder: pd.DataFrame) -> float:
    wrong = np.flatnonzero(~ladder["finding"].isin(ANSWERED))
    if ladder.empty or (wrong.size and wrong[0] == 0):
        return float("nan")
    return 10.0 ** float(ladder["rung"].iloc[wrong[0] - 1]) if wrong.size else 0.0


def first_short_rung(attempts: pd.DataFrame) -> pd.Series[int]:
    """Solver -> the widest rung at which a miss shortens its path; the widest rung first."""
    short = attempts[attempts["finding"] == "by its miss"]
    return short.groupby("solver")["rung"].max().sort_values(ascending=False)


def right_everywhere(attempts: pd.DataFrame) -> dict[str, bool]:
    """Solver -> whether all its answers are the shortest path, coarse or not."""
    right = attempts["finding"].isin(ANSWERED).groupby(attempts["solver"]).all()
    return {solver: bool(right[solver]) for solver in solver_order(list(right.index))}


# Finding -> colour, marker, filled.
_LOOK = {
    "right": (BLUE, "s", True),
    "coarse": (BLUE, "s", False),
    "by its miss": (ORANGE, "^", True),
    "wrong basin": (VERMILION, "X", True),
    "no path": (INK, "_", True),
}


def plot_ladder(
    ax: Axes, table: pd.DataFrame, solvers: list[str], names: Mapping[str, str], arrives: float
) -> None:
    """Draw the finding at each rung, one line per solver.

    Args:
        ax: where to draw.
        table: columns solver, rung (power of ten), finding, false_claims.
        solvers: all that have a line.
        names: solver -> its short name.
        arrives: power of ten of the largest miss that the check allows, drawn as a line.
    """
    lines = {solver: i for i, solver in enumerate(solver_order(solvers)[::-1])}
    for finding in FINDINGS:
        group = table[table["finding"] == finding]
        look = {"markersize": 5, **_mark(*_LOOK[finding])}
        ax.plot(group["rung"], group["solver"].map(lines), **look)
    false = table[table["false_claims"] > 0]
    ax.plot(false["rung"], false["solver"].map(lines), **_FALSE_CLAIM)
    mark_limit(ax, arrives).set_zorder(0)
    rungs = sorted(table["rung"].unique())
    ax.set_xticks(rungs, [power(10.0**r) if r % 3 == 0 else "" for r in rungs])
    ax.set(xlabel="margin / R", xlim=(max(rungs) + 0.6, min(rungs) - 0.6))
    ax.set_yticks(list(lines.values()), [names[solver] for solver in lines], color=INK)
    ax.set_ylim(-0.6, len(lines) - 0.4)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    only_grid(ax, "y")


def _mark(colour: str, marker: str, filled: bool) -> dict[str, Any]:
    face = colour if filled else "none"
    return {"linestyle": "none", "color": colour, "marker": marker, "markerfacecolor": face}


_FALSE_CLAIM = {**_mark(VERMILION, "o", False), "markersize": 9}


def legend_entries(table: pd.DataFrame) -> list[Line2D]:
    """Legend entries for the findings in the table, and for false claims."""
    looks = {
        finding: _mark(*_LOOK[finding])
        for finding in FINDINGS
        if (table["finding"] == finding).any()
    }
    if (table["false_claims"] > 0).any():
        looks["false claim"] = _FALSE_CLAIM
    return [Line2D([], [], label=label, **look) for label, look in looks.items()]


_ARRIVES = math.log10(ARRIVES)


def ladder_section(results: Results) -> Section | None:
    """Matrix of solvers and margins, the margins down to which each is right, and why."""
    attempts = rungs(results.rows)
    if attempts.empty:
        return None
    table, names = ladder(attempts), Palette.of_page(results).names(attempts["solver"])
    named = attempts.assign(solver=attempts["solver"].map(names))
    text = (
        "Targets at margins of 1e-1 to 1e-12 R from a turning circle, on both sides of its front "
        "half, across which the shortest length jumps, and of its rear half, across which it does "
        "not."
    )
    text = sentences(text, _short_by_miss(named), _verdicts(named), _other_sides(named))
    blocks: list[Picture | Table] = [_picture(table, names), _table(down_to(table))]
    lead = (
        "Follow a solver's line to the right, toward the circle: where its mark changes, a margin "
        "has become too small for it."
    )
    return Section("ladder", "The ladder toward a turning circle", text, tuple(blocks), lead)


def _short_by_miss(attempts: pd.DataFrame) -> str:
    inner = attempts[attempts["side"] == JUMP]
    if inner.empty:
        return ""
    short = first_short_rung(inner)
    others = [solver for solver, right in right_everywhere(inner).items() if right]
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
    others = attempts[attempts["side"] != JUMP]
    if others.empty:
        return ""
    right = right_everywhere(others)
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
    sides = [side for side in SIDES if (table["side"] == side).any()]
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
        *(Column(side, side, _reach) for side in SIDES),
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
