"""The right turn that an interior-point solver leaves.

The shortest path has no such turn. In the paper's model (4.12) LS is a degenerate minimum: along
the feasible curve the length grows like z2^3 / (3 R^2). A barrier of weight mu adds -mu ln z2, so
an interior point that stops at mu stops at z2 = (mu R^2)^(1/3), where the length is mu / 3 too long
(docs/derivation.md, section 7). Both hold to first order in z2 / R.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results, Settings
from dubins_study.report.elements.content import Section, Topic, picture
from dubins_study.report.elements.formats import count, digits, sentences, some
from dubins_study.report.elements.looks import LINES, labels_of
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import BLUE, MUTED, VERMILION, log_axis
from dubins_study.report.statistics.metrics import fitted_order, parse_spec
from dubins_study.study.path import Path

# Ipopt's constants (Waechter and Biegler 2006, sec. 2 and 3): the first barrier mu; the factor and
# the power of its update, min(0.2 mu, mu^1.5); and its smallest value as a share of the tolerance.
_MU_INIT = 0.1
_KAPPA = 0.2
_THETA = 1.5
_FLOOR = 1 / 11

_ROUNDING = 1e-15  # rad; a smaller turn is rounding
_FOLLOWS = 0.1  # largest |ratio - 1| that confirms the prediction

# Whether a setting gives the barrier -> the mark of an attempt.
MARKS = {
    True: Mark("told", "Ipopt told to stop at μ", BLUE, "o", filled=False),
    False: Mark("default", "Ipopt by its defaults", VERMILION, "x"),
}


def last_barrier(tol: float) -> float:
    """The barrier at which Ipopt stops by default.

    It is the first one of Ipopt's sequence within `tol`.
    """
    mu = _MU_INIT
    while mu > tol:
        mu = max(_FLOOR * tol, min(_KAPPA * mu, mu**_THETA))
    return mu


def left_over(results: Results) -> pd.DataFrame:
    """Attempts that returned a path, with its right turn.

    Added are the columns z2 (length of the right turn, length unit; 0 if it is only rounding), mu
    (barrier at which the solver stops; NaN if it has no barrier), barrier_set (whether a setting
    gives that barrier), predicted ((mu R^2)^(1/3)), ratio (z2 / predicted), excess_ratio ((length -
    reference) / (mu / 3)).
    """
    rows = results.rows[results.rows["length"].notna()]
    settings = results.settings
    barriers = {spec: barrier(spec, settings) for spec in rows["solver"].unique()}
    mu = rows["solver"].map(barriers).astype(float)
    predicted = np.cbrt(mu * rows["radius"] ** 2)
    turns = [_right_turn(results.path(index)) for index in rows.index]
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


def _right_turn(path: Path | None) -> float:
    """The total length of right turns, or NaN."""
    if path is None:
        return math.nan
    return float(path.lengths[path.curvatures < 0].sum())


# what Ipopt is asked for by the setting `options`, where `tol` is 0
_TOLERANCES = {"equal": 1e-9, "default": 1e-8, "tuned": 1e-8}


def barrier(spec: str, settings: Settings) -> float:
    """The barrier at which a solver stops, or NaN.

    Only Ipopt on the unsplit model has one here. `settings` maps each spec to all its settings.
    """
    group = settings.get(spec, {})
    if parse_spec(spec)[0] != "ipopt" or group.get("model") != "joint":
        return math.nan
    tol = group["tol"] or _TOLERANCES[group["options"]]
    return float(group["mu_target"] or last_barrier(tol))


def slope(table: pd.DataFrame) -> float:
    """The fitted slope of log z2 against log predicted.

    The fit is by least squares; NaN if there are fewer than two different predictions.
    """
    return -fitted_order(table["predicted"], table["z2"], floor=0.0)  # an order is minus a slope


def plot_bias(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the remaining turn against its prediction.

    The line is where they are equal. Columns: predicted, z2 (length unit), barrier_set (whether a
    setting gives the barrier).
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
    """The section on the remaining turn.

    A figure compares it with its prediction.
    """
    table = left_over(results)
    table = table[(table["branch"] == "best") & table["z2"].notna()]
    with_barrier = table[table["mu"].notna()]
    if with_barrier.empty:
        return None
    text = sentences(
        "The shortest path to this target is LS, so the paper's model L(z₁) R(z₂) S(z₃) should "
        "answer with z₂ = 0. There its reduced cost is zero: the length grows only like "
        "z₂³ / (3 R²). So a barrier −μ ln z₂ stops the turn at z₂ = (μ R²)^(1/3), where the "
        "path is μ / 3 too long.",
        _prediction(with_barrier),
        _without_barrier(table[table["mu"].isna()], results),
    )
    lead = (
        "An interior-point solver leaves a turn in a path that should have none; the length hides "
        "it. Marks on the dashed line confirm the prediction of this turn."
    )
    figure = picture(
        "bias",
        plot_bias,
        with_barrier,
        caption="The turn that Ipopt leaves, against the cube root of barrier times radius "
        "squared; one mark per attempt. On the dashed line both are equal.",
        alt="Turn left over against its prediction",
        height=3.9,
        legend=1,
    )
    return Section("bias", "The interior-point bias in the segments", text, (figure,), lead)


def _prediction(with_barrier: pd.DataFrame) -> str:
    """Sentences on how well z2 follows its prediction.

    They state the largest deviation, and the slope in logarithms.
    """
    deviation = float((with_barrier["ratio"] - 1).abs().max())
    deviation_text = digits(2)(deviation)
    comparison = f"is within a relative {deviation_text} of this"
    if deviation > _FOLLOWS:
        comparison = (
            f"does not follow this everywhere: it is up to a relative {deviation_text} away"
        )
    failed = int((with_barrier["claim"] == "failed").sum())
    failures = ""
    if failed:
        failures = f", though the solver calls {failed} of them failures"
    excess = with_barrier["excess_ratio"]
    return (
        f"Over {count(len(with_barrier))} attempts z₂ {comparison}; the slope in logarithms is "
        f"{digits(5)(slope(with_barrier))}{failures}. The paths are too long by "
        f"{digits(3)(excess.min())} to {digits(3)(excess.max())} times μ / 3."
    )


def _without_barrier(others: pd.DataFrame, results: Results) -> str:
    """Sentences on the turns that other methods leave.

    `others` are attempts of methods without a barrier. The text is empty if there are none.
    """
    if others.empty:
        return ""
    most = (others["z2"] / others["radius"]).groupby(others["solver"]).max()
    worst = labels_of(results)[str(most.idxmax())]
    return (
        "With a multiplier of zero, an active-set method has no reason to put the turn at its "
        f"bound. Of {some(len(most), 'method')} without a barrier {count((most == 0).sum())} leave "
        f"no turn; {worst} leaves up to {digits(2)(most.max())} R."
    )


TOPIC = Topic("the interior-point bias", bias_section, "bias")
