"""The same scenario at many radii, with the same lengths in radii.

The problem has no scale: (x, y, R) -> k (x, y, R) multiplies every length by k. A solver that keeps
this gives the same path in radii, and its iterations do not change.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.ticker import LogLocator

from dubins_study.report.data.attempts import own
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, sentences, share, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.elements.style import WIDE, mark_limit, power
from dubins_study.report.statistics.methods import MOST_CURVES
from dubins_study.report.statistics.metrics import by_solver, parse_spec, solver_order, success

# Spreads of length / R up to this are rounding: of the scenario's numbers, of the sum of up to a
# hundred pieces, and of the division. Gaps up to this count as zero.
ROUNDING = 1e-13
_FOOT, _TOP = 1e-17, 1e1  # gaps at which rounding and misses are drawn

COLUMNS = (
    SOLVER,
    *columns(count, scenarios="scenarios", invariant="of them invariant"),
    *columns(share, success="right"),
    *columns(digits(2), spread="largest spread of length / R"),
    *columns(lambda same: "yes" if same else "no", kind="text", words="same word"),
    *columns(digits(3), iterations="iterations, most / least"),
)


def spreads(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver and scenario (label), over its radii.

    Columns: solver, label, success (share), spread (of length / R over the radii at which the
    answer arrives, relative to its median; NaN if it never does), words (whether all are one),
    iterations (most over least; NaN if not counted or zero), invariant (all radii alike: every
    answer arrives, same verdict and word, spread within `ROUNDING`).
    """
    arrived = (rows["length"] / rows["radius"]).where(rows["gap"].notna())
    measured = rows.assign(success=success(rows), relative=arrived)
    groups = measured.groupby(["label", "solver"])
    relative, least = groups["relative"], groups["iterations"].min()
    frame = pd.DataFrame({"success": groups["success"].mean()})
    frame["spread"] = (relative.max() - relative.min()) / relative.median()
    frame["words"] = groups["word"].nunique() <= 1
    frame["iterations"] = groups["iterations"].max() / least.where(least > 0)
    alike = (groups["verdict"].nunique() == 1) & frame["words"]
    arrive = relative.count() == groups.size()
    frame["invariant"] = alike & arrive & ~(frame["spread"] > ROUNDING)
    return frame.reset_index()


def dependence(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, from `spreads`: `COLUMNS`, with the largest spread and iterations."""
    frame = table.groupby("solver").agg(
        scenarios=("label", "size"),
        invariant=("invariant", "sum"),
        success=("success", "mean"),
        spread=("spread", "max"),
        words=("words", "all"),
        iterations=("iterations", "max"),
    )
    return by_solver(frame.reset_index())


def scale_section(results: Results) -> Section | None:
    """Gap against radius, and a table of what changes with the radius."""
    rows = results.rows
    posed = (rows["branch"] == "best") & (rows["initial_guess"] == "cold")
    rows = rows[posed & rows["radius"].notna()]
    if rows.empty:
        return None
    table, palette = dependence(spreads(rows)), Palette.of_page(results)
    level = table["invariant"] == table["scenarios"]
    # The solvers that depend on the unit have a curve, then others.
    mine = own(table["solver"])
    first = [*dict.fromkeys([*mine, *table[~level]["solver"], *table[level]["solver"]])]
    first = first[:MOST_CURVES]
    text = sentences(
        "Nothing in the problem has a size: with start and target given in radii, the path in "
        "radii is the same at every radius. Each scenario is solved at "
        f"{count(rows['radius'].nunique())} radii from {power(rows['radius'].min())} to "
        f"{power(rows['radius'].max())} length units.",
        _findings(table[level], table[~level], palette.names(table["solver"])),
    )
    caption = (
        "Over the radii of each scenario. Invariant: same verdict and word at every radius, and "
        f"lengths in radii within {digits(1)(ROUNDING)}. Spread: greatest less least length in "
        "radii, relative, over the answers that arrive."
    )
    varies = marks(pd.DataFrame({"invariant": ~level}), "invariant")
    blocks = (
        _picture(rows, solver_order(first), palette),
        Table("scale", caption, table, COLUMNS, varies),
    )
    lead = (
        "A level line is a solver that does not care about the unit of length; one that bends has "
        "a tolerance that does not grow with the radius."
    )
    return Section("scale", "From micrometres to megametres", text, blocks, lead)


def _findings(same: pd.DataFrame, other: pd.DataFrame, names: Mapping[str, str]) -> str:
    """Which solvers depend on the unit of length, and why."""
    units = [parse_spec(solver)[1].get("units") == "scenario" for solver in other["solver"]]
    why = (
        ": they are given the model in the scenario's own unit, as the paper poses it, and their "
        "tolerances do not grow with it"
    )
    return sentences(
        f"{len(same)} of {len(same) + len(other)} solvers and variants give the same path "
        "everywhere.",
        f"Not so for {', '.join(names[solver] for solver in other['solver'])}"
        f"{why if all(units) else ''}."
        if len(other)
        else "None depends on the unit.",
    )


def _picture(rows: pd.DataFrame, solvers: list[str], palette: Palette) -> Picture:
    """Gap against radius, a panel per scenario and a line per solver."""
    shown = rows[rows["solver"].isin(solvers)].sort_values("radius")
    # Many are exact: each solver is drawn a little higher than the last, so that all are visible.
    foot = _FOOT * 10 ** (0.28 * shown["solver"].map(solvers.index))
    gap = shown["gap"].where(shown["gap"] > ROUNDING, foot).where(shown["gap"].notna(), _TOP)
    names = palette.names(solvers)
    lines = by_solver(shown.assign(gap=gap, name=shown["solver"].map(names), panel=shown["label"]))
    axes = "turning radius R (length unit)", "gap to the shortest length (relative)"
    figure = parameter_lines(lines, "radius", "gap", palette, *axes, width=WIDE, height=3.6)
    ticks = 10.0 ** np.arange(round(np.log10(ROUNDING)), round(np.log10(_TOP)) - 1, 3)
    for ax in figure.axes:
        mark_limit(ax, ROUNDING, "y")
        ax.set_ylim(_FOOT / 3, _TOP * 4)
        ax.set_yticks([_FOOT * 10, *ticks, _TOP], ["rounding", *map(power, ticks), "misses"])
        ax.xaxis.set_major_locator(LogLocator(numticks=5))
    others = rows["solver"].nunique() - len(solvers)
    more = f"Level too, and left out: the lines of {some(others, 'more solver')}."
    caption = sentences(
        "Gap against radius, one panel per scenario. The line of a scale-free solver is level. "
        "Below the dotted line are answers exact up to rounding, set apart so that each is seen; "
        "at the top are those that do not arrive.",
        more if others else "",
    )
    return Picture("scale", caption, figure, "Gap against radius for each solver")


TOPIC = Topic("scale invariance", scale_section, "scale")
