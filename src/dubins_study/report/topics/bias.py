"""The turn that remains in a solver's path though the shortest path has no such turn.

In the paper's model (4.12) LS is a degenerate minimum: along the feasible curve the length grows
like z2^3 / (3 R^2). A barrier of weight mu adds -mu ln z2, so an interior point that stops at mu
stops at z2 = (mu R^2)^(1/3), where the length is mu / 3 too long (docs/derivation.md, section 7).
Both hold to first order in z2 / R.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Section, Table, Topic, picture
from dubins_study.report.elements.formats import count, digits, sentences
from dubins_study.report.elements.looks import LINES
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import BLUE, MUTED, VERMILION, log_axis
from dubins_study.report.statistics.metrics import fitted_order, parse_spec

# Ipopt's constants (Waechter and Biegler 2006, sec. 2 and 3): the first barrier mu; the factor and
# the power of its update, min(0.2 mu, mu^1.5); and its smallest value as a share of the tolerance.
_MU_INIT, _KAPPA, _THETA, _FLOOR = 0.1, 0.2, 1.5, 1 / 11

_ROUNDING = 1e-15  # rad; a smaller turn is rounding
_FOLLOWS = 0.1  # largest |ratio - 1| that confirms the prediction

BARRIERS = (
    *columns(digits(3), mu="μ"),
    *columns(kind="text", by="chosen by"),
    *columns(count, attempts="radii"),
    *columns(digits(5), slope="slope", ratio_low="z₂ / predicted, least", ratio_high="most"),
    *columns(digits(3), excess_low="excess / (μ/3), least", excess_high="most"),
    *columns(count, failed="“failed”"),
)
OTHERS = (
    SOLVER,
    *columns(count, attempts="radii", exact="no turn at all"),
    *columns(digits(2), least="least z₂ / R", most="most", gap="largest gap"),
    *columns(count, limits="stopped by a limit"),
)
# Whether a setting gives the barrier -> the mark of an attempt.
MARKS = {
    True: Mark("told", "Ipopt told to stop at μ", BLUE, "o", filled=False),
    False: Mark("default", "Ipopt by its defaults", VERMILION, "x"),
}


def last_barrier(tol: float) -> float:
    """The barrier at which Ipopt stops by default: the first one of its sequence within `tol`."""
    mu = _MU_INIT
    while mu > tol:
        mu = max(_FLOOR * tol, min(_KAPPA * mu, mu**_THETA))
    return mu


def left_over(results: Results) -> pd.DataFrame:
    """The study's attempts that returned a path, with the length of its right turn.

    Adds the columns z2 (length of the right turn, length unit; 0 if it is only rounding), mu
    (barrier at which the solver stops; NaN if it has no barrier), barrier_set (whether a setting
    gives that barrier), predicted ((mu R^2)^(1/3)), ratio (z2 / predicted), excess_ratio
    ((length - reference) / (mu / 3)).
    """
    rows = results.rows[results.rows["length"].notna()]
    settings = results.settings
    barriers = {spec: barrier(spec, settings) for spec in rows["solver"].unique()}
    mu = rows["solver"].map(barriers).astype(float)
    predicted = np.cbrt(mu * rows["radius"] ** 2)
    paths = [results.path(index) for index in rows.index]
    turns = [math.nan if p is None else p.lengths[p.curvatures < 0].sum() for p in paths]
    z2 = pd.Series(turns, rows.index, dtype=float)
    z2 = z2.mask(z2 < _ROUNDING * rows["radius"], 0.0)
    return rows.assign(
        z2=z2,
        mu=mu,
        barrier_set=rows["solver"].str.contains("mu_target="),
        predicted=predicted,
        ratio=z2 / predicted,
        excess_ratio=(rows["length"] - rows["reference"]) / (mu / 3),
    )


# what Ipopt is asked for by the setting `options`, where `tol` is 0
_TOLERANCES = {"equal": 1e-9, "default": 1e-8, "tuned": 1e-8}


def barrier(spec: str, settings: Mapping[str, Mapping[str, Any]]) -> float:
    """The barrier at which a spec stops on the unsplit model; NaN for any other solver."""
    group = settings.get(spec, {})
    if parse_spec(spec)[0] != "ipopt" or group.get("model") != "joint":
        return math.nan
    tol = group["tol"] or _TOLERANCES[group["options"]]
    return float(group["mu_target"] or last_barrier(tol))


def slope(table: pd.DataFrame) -> float:
    """Slope of log z2 against log predicted by least squares; NaN if there are not two places."""
    return -fitted_order(table["predicted"], table["z2"], floor=0.0)


def by_barrier(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver with a barrier, from `left_over`, sorted by falling barrier.

    Columns: solver, those of `BARRIERS`, barrier_set. The slope is that of log z2 against log
    predicted over the radii; low and high are the smallest and the largest value.
    """
    known = table[table["mu"].notna()]
    groups = known.assign(failed=known["claim"] == "failed").groupby("solver", sort=False)
    frame = groups.agg(
        mu=("mu", "first"),
        barrier_set=("barrier_set", "first"),
        attempts=("mu", "size"),
        ratio_low=("ratio", "min"),
        ratio_high=("ratio", "max"),
        excess_low=("excess_ratio", "min"),
        excess_high=("excess_ratio", "max"),
        failed=("failed", "sum"),
    )
    frame["by"] = frame["barrier_set"].map({True: "told", False: "its defaults"})
    frame["slope"] = pd.Series({s: slope(g) for s, g in groups}, dtype=float)
    return frame.reset_index().sort_values("mu", ascending=False, ignore_index=True)


def without_barrier(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver without a known barrier, from `left_over`: the columns `OTHERS`."""
    others = table[table["mu"].isna()]
    turn = others["z2"] / others["radius"]
    measured = others.assign(turn=turn, exact=turn == 0, limit=others["claim"] == "limit")
    frame = measured.groupby("solver").agg(
        attempts=("turn", "size"),
        exact=("exact", "sum"),
        least=("turn", "min"),
        most=("turn", "max"),
        gap=("gap", "max"),
        limits=("limit", "sum"),
    )
    return frame.reset_index()


def plot_bias(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the remaining turn against its prediction, and the line where they are equal.

    Columns: predicted, z2 (length unit), barrier_set (whether a setting gives the barrier).
    """
    ends = (0.5 * table["predicted"].min(), 2 * table["predicted"].max())
    ax.plot(ends, ends, color=MUTED, linewidth=0.9, linestyle=LINES[1], label="equal")
    for barrier_set, mark in MARKS.items():
        group = table[table["barrier_set"] == barrier_set]
        if len(group):
            ax.plot(group["predicted"], group["z2"], label=mark.label, **mark.dots())
    ax.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    ax.set(xlabel="(μ R²)^(1/3)  (length unit)", ylabel="right turn left over, z₂ (length unit)")
    log_axis(ax.xaxis)
    log_axis(ax.yaxis)


def bias_section(results: Results) -> Section | None:
    """The remaining turn against its prediction, and the turn that other methods leave."""
    table = left_over(results)
    table = table[(table["branch"] == "best") & table["z2"].notna()]
    with_barrier = table[table["mu"].notna()]
    if with_barrier.empty:
        return None
    text = sentences(
        "The shortest path to this target is LS, and the paper's model L(z₁) R(z₂) S(z₃) should "
        "answer with z₂ = 0. There its reduced cost is zero: the length grows only like "
        "z₂³ / (3 R²), so a barrier −μ ln z₂ stops the turn at z₂ = (μ R²)^(1/3), where the "
        "length is μ / 3 too long.",
        _prediction(with_barrier),
    )
    lead = (
        "Marks on the dashed line confirm the prediction: how much turn an interior-point solver "
        "leaves in a path that should have none, while its length shows nothing."
    )
    figure = picture(
        "bias",
        plot_bias,
        with_barrier,
        caption="The turn that Ipopt leaves, against the cube root of barrier times radius "
        "squared; one mark per attempt. On the dashed line they are equal.",
        alt="Turn left over against its prediction",
        height=3.9,
        legend=1,
    )
    barriers = Table(
        "bias",
        "Ipopt by the barrier that it stops at, over the radii: slope of log z₂ against the "
        "prediction's logarithm, ratio of z₂ to it, and by how much the path is longer than the "
        "shortest, over μ / 3. In quotation marks: attempts that the solver calls failed.",
        by_barrier(table),
        BARRIERS,
    )
    others = Table(
        "bias-methods",
        "Methods that are told no barrier. On the unsplit model (joint) a multiplier of zero "
        "gives an active-set method no reason to put the turn at its bound; with one turn "
        "fixed at zero, as the paper's Algorithm 1 does, the other turn can be left out.",
        without_barrier(table),
        OTHERS,
    )
    blocks = (figure, barriers, others) if len(others.frame) else (figure, barriers)
    return Section("bias", "The interior-point bias in the segments", text, blocks, lead)


def _prediction(with_barrier: pd.DataFrame) -> str:
    """How well z2 is predicted, as the largest deviation and the slope."""
    deviation = float((with_barrier["ratio"] - 1).abs().max())
    shown = digits(2)(deviation)
    comparison = f"is within a relative {shown} of this"
    if deviation > _FOLLOWS:
        comparison = f"does not follow this everywhere: it is up to a relative {shown} away"
    failed = int((with_barrier["claim"] == "failed").sum())
    failures = f", though the solver calls {failed} of them failures" if failed else ""
    return (
        f"Over {count(len(with_barrier))} attempts z₂ {comparison}; the slope in logarithms is "
        f"{digits(5)(slope(with_barrier))}{failures}."
    )


TOPIC = Topic("the interior-point bias", bias_section, "bias")
