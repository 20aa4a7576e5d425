"""The section on margins toward a turning circle."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, Topic, panels_picture
from dubins_study.report.elements.formats import count, digits, sentences, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import (
    INK,
    MAP_PAPER,
    VERMILION,
    mark_limit,
    power,
)
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.maps import kind_maps
from dubins_study.study.tolerances import ARRIVES

SIDES = ("front, inside", "front, outside", "rear, inside", "rear, outside")
JUMP = "front, inside"  # here the length is up to 2 pi R above that on the circle's other side
# Results of an attempt, the best first; from light to dark.
MARKS = (
    Mark("right", colour="#d9ecdf"),
    Mark("coarse", colour="#6fb6dd", marker="."),
    Mark("by its miss", colour="#d68a1c", marker="^"),
    Mark("wrong basin", colour=MAP_PAPER, marker="x"),
    Mark("no path", colour="#5d636b"),
)
FINDINGS = tuple(mark.key for mark in MARKS)
# Relative; along one word a miss of 1e-6 R shortens a path by far less.
SHORTER = 1e-4


def rungs(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts near a circle, with rung and finding.

    A rung is a power of ten of the margin. The findings, from the best to the worst:

    - `right`: optimal, and as long as the scenario's shortest path.
    - `coarse`: longer, but with the same shape.
    - `by its miss`: it ends beside the target, within the tolerance, where the way is much shorter.
      The check accepts it, but it is no shortest path of the scenario.
    - `wrong basin`: longer, with another shape.
    - `no path`: no path was returned, or it does not arrive.

    Columns: solver, side, rung (exponent of ten), finding, false_claim, miss (radii).
    """
    group = rows[(rows["branch"] == "best") & (rows["margin"] > 0)]
    dx = group["target_x"] - group["x"]
    dy = group["target_y"] - group["y"]
    ahead = dx * np.cos(group["heading"]) + dy * np.sin(group["heading"])
    inside = group["region"].str.endswith("disc").eq(True)
    optimal = group["verdict"] == "optimal"
    longer = group["verdict"] == "longer"
    # shorter than any path to the target itself
    short = group["length"] < (1 - SHORTER) * group["reference_low"].fillna(0.0)
    basin = group["wrong_basin"].astype(bool)
    # of the findings that an attempt fits, the first counts
    kinds = {
        "right": optimal & ~short,
        "coarse": longer & ~basin,
        "by its miss": optimal & short,
        "wrong basin": longer,
    }
    finding = np.select(list(kinds.values()), list(kinds), default="no path")
    return pd.DataFrame(
        {
            "solver": group["solver"],
            "side": np.where(ahead > 0, "front, ", "rear, ")
            + np.where(inside, "inside", "outside").astype(object),
            "rung": np.round(np.log10(group["margin"])).astype("int64"),
            "finding": pd.Categorical(finding, FINDINGS, ordered=True),
            "false_claim": group["false_claim"].astype(bool),
            "miss": group["miss"] / group["radius"],
        }
    )


def ladder(attempts: pd.DataFrame) -> pd.DataFrame:
    """The worst finding of each solver, side and rung.

    `attempts` are those of `rungs`. Columns: solver, side, rung, finding (the worst), false_claim
    (whether any attempt has one).
    """
    groups = attempts.groupby(["solver", "side", "rung"], sort=False)
    return groups[["finding", "false_claim"]].max().reset_index()


def ladder_section(results: Results) -> Section | None:
    """The section with maps of solvers and margins."""
    attempts = rungs(results.rows)
    if attempts.empty:
        return None
    table = ladder(attempts)
    short = attempts[(attempts["finding"] == "by its miss") & (attempts["side"] == JUMP)]
    trade = "Just inside the front half no solver gets a shorter path by a miss."
    if len(short):
        trade = (
            "Just inside the front half a small miss makes a path shorter by up to a full turn: "
            f"{some(len(short), 'answer')} by a miss of at most {digits(2)(short['miss'].max())} "
            "R. The check calls these optimal: its reference is the least length over targets "
            "within the miss."
        )
    text = sentences(
        "Targets at margins of 1e-1 to 1e-12 R from a turning circle, on both sides. The shortest "
        "length jumps across the front half of the circle, not across the rear half.",
        trade,
        f"Of all {count(len(attempts))} claims {count(attempts['false_claim'].sum())} are false.",
    )
    lead = (
        "Follow a solver's line to the right, toward the circle. Where its colour changes, the "
        "margin is too small for this solver."
    )
    blocks = (_picture(table, Palette.of_page(results)),)
    return Section("ladder", "The ladder toward a turning circle", text, blocks, lead)


def _picture(table: pd.DataFrame, palette: Palette) -> Picture:
    """The maps of solvers and margins, one per side.

    `table` is that of `ladder`.
    """
    names = palette.names(table["solver"])
    order = solver_order(list(names))[::-1]
    placed = table.assign(
        x=-table["rung"], y=table["solver"].map(order.index), kind=table["finding"]
    )
    panels = {side: rows for side, rows in placed.groupby("side") if len(rows)}

    def dress(ax: Axes, rows: pd.DataFrame) -> None:
        """Ring false claims; draw limit and axes' names."""
        false = rows[rows["false_claim"]]
        ax.plot(false["x"], false["y"], "o", color=VERMILION, markersize=7, markerfacecolor="none")
        mark_limit(ax, -math.log10(ARRIVES))
        ax.set_xticks(range(3, 13, 3), [power(10.0**-rung) for rung in range(3, 13, 3)])
        ax.set_yticks(range(len(order)), [names[solver] for solver in order], color=INK)
        ax.set_xlabel("margin / R")

    return panels_picture(
        "ladder",
        "The worst answer at each margin, on both sides of both halves of the circle. Right: the "
        "shortest path. Coarse: its shape, but longer than the tolerance allows. By its miss: "
        "optimal for the point where it ends, but shorter than any path to the target. Ringed: "
        f"false claims. Dotted: the largest miss that counts as arriving, {power(ARRIVES)} R.",
        kind_maps,
        "Map of solvers and margins, a panel per side of the circle",
        panels,
        MARKS,
        dress,
        high=min(0.7 + 0.19 * len(order), 5.95),
    )


TOPIC = Topic("the ladder toward a circle", ladder_section, "ladder")
