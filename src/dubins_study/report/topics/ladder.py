"""The section on the ladder of margins toward a turning circle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Picture, Section, Table, Topic, panels_picture
from dubins_study.report.elements.formats import ABSENT, count, digits, sentences, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import (
    BLUE,
    HALF,
    INK,
    ORANGE,
    VERMILION,
    WIDE,
    Style,
    mark_limit,
    new_figure,
    only_grid,
    power,
)
from dubins_study.report.statistics.metrics import by_solver, solver_order
from dubins_study.study.tolerances import ARRIVES

SIDES = ("front, inside", "front, outside", "rear, inside", "rear, outside")
JUMP = "front, inside"  # here the length is up to 2 pi R above that on the circle's other side
# Results of an attempt, the best first.
MARKS = (
    Mark("right", "right", BLUE, "s"),
    Mark("coarse", "coarse", BLUE, "s", filled=False),
    Mark("by its miss", "by its miss", ORANGE, "^"),
    Mark("wrong basin", "wrong basin", VERMILION, "X"),
    Mark("no path", "no path", INK, "_"),
)
FINDINGS = tuple(mark.key for mark in MARKS)
ANSWERED = ("right", "coarse")  # the shortest path, accurate or not
# Relative; along one word a miss of 1e-6 R shortens a path by far less.
SHORTER = 1e-4
_FALSE_CLAIM = Mark("false claim", "", VERMILION, "o", filled=False).dots() | {"markersize": 9}
_ARRIVES = math.log10(ARRIVES)


def _margin(value: Any) -> str:
    number = float(value)
    return "all" if number == 0 else f"1e{round(math.log10(number))}" if number > 0 else ABSENT


COLUMNS = (
    SOLVER,
    *columns(count, attempts="attempts"),
    *columns(_margin, **dict(zip(SIDES, SIDES, strict=True))),
    *columns(
        count, by_miss="rungs by its miss", coarse="rungs coarse", false_claims="false claims"
    ),
)


def rungs(rows: pd.DataFrame) -> pd.DataFrame:
    """Every attempt with its place on the ladder and its finding.

    `right`: optimal, and as long as the scenario's shortest path. `by its miss`: the check accepts
    it as optimal, since it is the shortest to where it ends, but it is shorter than the scenario's
    shortest path. `coarse`: longer, but with the same shape. `wrong basin`: longer, with
    another shape. `no path`: no path was returned, or it does not arrive.

    Columns solver, side, rung (margin as a power of ten), finding, false_claim, miss (radii).
    """
    group = rows[(rows["branch"] == "best") & (rows["margin"] > 0)]
    cos, sin = np.cos(group["heading"]), np.sin(group["heading"])
    ahead = (group["target_x"] - group["x"]) * cos + (group["target_y"] - group["y"]) * sin
    side = (ahead > 0).map({True: "front, ", False: "rear, "})
    inside = group["region"].str.endswith("disc").eq(True)
    optimal, longer = group["verdict"] == "optimal", group["verdict"] == "longer"
    short = profits_from_its_miss(group)
    basin = group["wrong_basin"].astype(bool)
    kinds = [optimal & ~short, longer & ~basin, optimal & short, longer]
    return pd.DataFrame(
        {
            "solver": group["solver"],
            "side": side + inside.map({True: "inside", False: "outside"}),
            "rung": np.round(np.log10(group["margin"])).astype("int64"),
            "finding": np.select(kinds, FINDINGS[:4], default=FINDINGS[4]),
            "false_claim": group["false_claim"].astype(bool),
            "miss": group["miss"] / group["radius"],
        }
    )


def profits_from_its_miss(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether each answer is shorter than any path to the target itself."""
    return rows["length"] < (1 - SHORTER) * rows["reference_low"].fillna(0.0)


def ladder(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, side and rung, from the attempts that `rungs` returns.

    Columns solver, side, rung, attempts, finding (the worst one), false_claims.
    """
    place = attempts["finding"].map({finding: i for i, finding in enumerate(FINDINGS)})
    groups = attempts.assign(place=place).groupby(["solver", "side", "rung"], sort=False)
    frame = groups.agg(
        attempts=("place", "size"), finding=("place", "max"), false_claims=("false_claim", "sum")
    )
    return frame.assign(finding=[FINDINGS[i] for i in frame["finding"]]).reset_index()


def down_to(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, from the table that `ladder` returns.

    Columns: those of `COLUMNS`. Of each side the smallest margin such that at this margin and all
    wider ones every answer is the shortest path, coarse or not (0 if this holds for all margins,
    NaN if it does not hold at the widest); by_miss counts rungs on the inner side of the jump.
    """
    by_miss = (table["finding"] == "by its miss") & (table["side"] == JUMP)
    groups = table.assign(coarse=table["finding"] == "coarse", by_miss=by_miss).groupby("solver")
    frame = groups[["attempts", "by_miss", "coarse", "false_claims"]].sum()
    widest_first = table.sort_values("rung", ascending=False).groupby(["side", "solver"])
    for side in SIDES:
        frame[side] = pd.Series(
            {solver: _least(rows) for (at, solver), rows in widest_first if at == side}, dtype=float
        )
    return by_solver(frame.reset_index())


def _least(rows: pd.DataFrame) -> float:
    """The margin before the first wrong answer, widest margin first; see `down_to`."""
    wrong = np.flatnonzero(~rows["finding"].isin(ANSWERED))
    if wrong.size == 0:
        return 0.0
    return 10.0 ** float(rows["rung"].iloc[wrong[0] - 1]) if wrong[0] else math.nan


def ladder_section(results: Results) -> Section | None:
    """Matrix of solvers and margins, the margins down to which each is right, and why."""
    attempts = rungs(results.rows)
    if attempts.empty:
        return None
    table, names = ladder(attempts), Palette.of_page(results).names(attempts["solver"])
    short = attempts[(attempts["finding"] == "by its miss") & (attempts["side"] == JUMP)]
    text = sentences(
        "Targets at margins of 1e-1 to 1e-12 R from a turning circle, on both sides of its front "
        "half, across which the shortest length jumps, and of its rear half, across which it does "
        "not.",
        "Just inside the front half a small miss buys a path shorter by up to a full turn: "
        f"{some(len(short), 'answer')} by a miss of at most {digits(2)(short['miss'].max())} R. "
        "The check, whose reference is the least length over the miss made, calls it optimal."
        if len(short)
        else "Just inside the front half no solver trades a miss for the short path.",
        f"Of all {count(len(attempts))} claims {count(attempts['false_claim'].sum())} are false.",
    )
    caption = (
        "The least margin (R) down to which every answer is the shortest path, coarse or not; "
        "all: at every margin asked for; –: not at the widest."
    )
    blocks = _picture(table, names), Table("ladder", caption, down_to(table), COLUMNS)
    lead = (
        "Follow a solver's line to the right, toward the circle: where its mark changes, a margin "
        "has become too small for it."
    )
    return Section("ladder", "The ladder toward a turning circle", text, blocks, lead)


def _picture(table: pd.DataFrame, names: Mapping[str, str]) -> Picture:
    caption = (
        "Both sides of both halves of the circle: the worst of the answers at a margin. Right: the "
        "shortest path. Coarse: its shape, but longer than the check's tolerance allows. By its "
        "miss: optimal for the point that it ends at, and shorter than any path to the target. "
        f"Dotted: the largest miss that counts as arriving, {power(10.0**_ARRIVES)} R."
    )
    alt = "Matrix of solvers and margins, a panel per side of the circle"
    return panels_picture("ladder", caption, _matrix, alt, table, names)


def _matrix(table: pd.DataFrame, names: Mapping[str, str], *, narrow: bool) -> Figure:
    """One panel per side of the circle, side by side or one below the other; names on the left."""
    order = solver_order(table["solver"].unique().tolist())[::-1]
    sides = [side for side in SIDES if (table["side"] == side).any()]
    down, across = (len(sides), 1) if narrow else (1, len(sides))
    high = 0.55 + down * min(0.7 + 0.19 * len(order), 5.95)
    figure = new_figure(HALF if narrow else WIDE, high)
    panels = figure.subplots(down, across, sharey=True, squeeze=False).ravel()
    placed = table.assign(line=table["solver"].map(order.index))
    for place, (ax, side) in enumerate(zip(panels, sides, strict=True)):
        _draw_side(ax, placed[placed["side"] == side])
        ax.set_title(side)
        ax.set_yticks(range(len(order)), [names[solver] for solver in order], color=INK)
        ax.set_ylim(-0.6, len(order) - 0.4)
        ax.tick_params(axis="y", length=0, labelleft=place % across == 0)
    looks = {mark.label: mark.dots() for mark in MARKS if (table["finding"] == mark.key).any()}
    if table["false_claims"].any():
        looks["false claim"] = _FALSE_CLAIM
    handles = [Line2D([], [], label=label, **look) for label, look in looks.items()]
    tight: Style = {"ncols": 3 if narrow else 6, "handletextpad": 0.2, "columnspacing": 1.2}
    figure.legend(handles=handles, loc="outside lower left", **tight)
    return figure


def _draw_side(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the finding at each rung. Columns: line (height), rung, finding, false_claims."""
    for mark in MARKS:
        group = table[table["finding"] == mark.key]
        ax.plot(group["rung"], group["line"], markersize=5, **mark.dots())
    false = table[table["false_claims"] > 0]
    ax.plot(false["rung"], false["line"], **_FALSE_CLAIM)
    mark_limit(ax, _ARRIVES).set_zorder(0)
    rungs = sorted(table["rung"].unique())
    ax.set_xticks(rungs, [power(10.0**r) if r % 3 == 0 else "" for r in rungs])
    ax.set(xlabel="margin / R", xlim=(max(rungs) + 0.6, min(rungs) - 0.6))
    ax.spines["left"].set_visible(False)
    only_grid(ax, "y")


TOPIC = Topic("the ladder toward a circle", ladder_section, "ladder")
