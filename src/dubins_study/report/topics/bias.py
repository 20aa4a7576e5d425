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
from dubins_study.report.elements.axes import log_axis, power
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.style import BLUE, INK, MUTED, VERMILION
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import fitted_order, parse_spec, solver_order
from dubins_study.study.path import FloatArray

# Ipopt's constants (Waechter and Biegler 2006, sec. 2 and 3): the first barrier mu; the factor and
# the power of its update, min(0.2 mu, mu^1.5); and its smallest value as a share of the tolerance.
_MU_INIT, _KAPPA, _THETA, _FLOOR = 0.1, 0.2, 1.5, 1 / 11

_ROUNDING = 1e-15  # rad; a smaller turn is rounding


def last_barrier(tol: float) -> float:
    """The barrier at which Ipopt stops by default: the first one of its sequence within `tol`."""
    mu = _MU_INIT
    while mu > tol:
        mu = max(_FLOOR * tol, min(_KAPPA * mu, mu**_THETA))
    return mu


def left_over(results: Results) -> pd.DataFrame:
    """The study's attempts that returned a path, with the length of its right turn.

    Args:
        results: results whose manifests hold the specs' settings.

    Returns:
        The rows with columns z2 (length of the right turn, length unit; 0 if it is only rounding),
        mu (barrier at which the solver stops; NaN if it has no barrier), barrier_set (whether a
        setting gives that barrier), joint (whether the model is unsplit), predicted
        ((mu R^2)^(1/3)), ratio (z2 / predicted), excess (length - reference), excess_ratio
        (excess / (mu / 3)).
    """
    settings = results.settings
    rows = results.rows[results.rows["length"].notna()]
    mu = rows["solver"].map(lambda spec: barrier(spec, settings)).astype(float)
    predicted = np.cbrt(mu * rows["radius"] ** 2)
    z2 = np.array([_right_turn(results, index) for index in rows.index], dtype=np.float64)
    z2[z2 < _ROUNDING * rows["radius"].to_numpy()] = 0.0
    excess = rows["length"] - rows["reference"]
    return rows.assign(
        z2=z2,
        mu=mu,
        barrier_set=rows["solver"].map(lambda s: _number(settings.get(s, {}).get("mu_target")) > 0),
        joint=rows["solver"].map(lambda s: settings.get(s, {}).get("model") == "joint"),
        predicted=predicted,
        ratio=z2 / predicted,
        excess=excess,
        excess_ratio=excess / (mu / 3),
    )


def barrier(spec: str, settings: Mapping[str, Mapping[str, Any]]) -> float:
    """The barrier at which a spec stops on the unsplit model; NaN for any other solver."""
    group = settings.get(spec, {})
    if parse_spec(spec)[0] != "ipopt" or group.get("model") != "joint":
        return math.nan
    target, tol = _number(group.get("mu_target")), _number(group.get("tol"))
    if target > 0:
        return target
    return last_barrier(tol) if tol > 0 else math.nan


def _number(value: Any) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan


def _right_turn(results: Results, index: int) -> float:
    path = results.path(index)
    return math.nan if path is None else float(path.length[path.curvature < 0].sum())


def slope(x: FloatArray, y: FloatArray) -> float:
    """Slope of log y against log x by least squares; NaN with fewer than two points to fit."""
    keep = np.isfinite(x) & (x > 0)
    return -fitted_order(x[keep], y[keep], floor=0.0)


def prediction_fit(with_barrier: pd.DataFrame) -> tuple[float, float]:
    """How well z2 is predicted in the attempts of `left_over` that have a barrier.

    Returns:
        The largest |z2 / predicted - 1|, and the slope of log z2 against log predicted.
    """
    predicted, z2 = (with_barrier[name].to_numpy() for name in ("predicted", "z2"))
    return float((with_barrier["ratio"] - 1).abs().max()), slope(predicted, z2)


def default_attempt(with_barrier: pd.DataFrame) -> pd.Series[Any] | None:
    """The attempt with the default barrier whose radius is nearest to 1; None if there is none."""
    default = with_barrier[~with_barrier["barrier_set"]]
    if default.empty:
        return None
    return default.iloc[int((default["radius"] - 1).abs().to_numpy().argmin())]


def by_barrier(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver with a barrier, from `left_over`, sorted by falling barrier.

    Columns: solver, mu, barrier_set, attempts, slope (of log z2 against log predicted, over the
    radii), ratio_low and ratio_high (smallest and largest z2 / predicted), excess_low and
    excess_high (smallest and largest excess / (mu / 3)), failed (attempts that the solver calls
    failed).
    """
    known = table[table["mu"].notna()]
    groups = known.assign(failed=known["claim"] == "failed").groupby("solver", sort=False)
    slopes = pd.Series({solver: prediction_fit(group)[1] for solver, group in groups}, dtype=float)
    frame = groups[["mu", "barrier_set"]].first().assign(attempts=groups.size(), slope=slopes)
    for name, column in (("ratio", "ratio"), ("excess", "excess_ratio")):
        frame[f"{name}_low"], frame[f"{name}_high"] = groups[column].min(), groups[column].max()
    frame = frame.assign(failed=groups["failed"].sum()).reset_index()
    return frame.sort_values("mu", ascending=False, ignore_index=True)


def without_barrier(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver without a known barrier, from `left_over`.

    Columns: solver, joint, attempts, exact (attempts without any right turn), least and most
    (smallest and largest z2 / R), gap (largest), limits (attempts stopped by a limit).
    """
    others = table[table["mu"].isna()]
    others = others.assign(turn=others["z2"] / others["radius"], limits=others["claim"] == "limit")
    groups = others.assign(exact=others["turn"] == 0).groupby("solver")
    turn, frame = groups["turn"], groups[["joint"]].first().assign(attempts=groups.size())
    frame = frame.assign(exact=groups["exact"].sum(), least=turn.min(), most=turn.max())
    return frame.assign(gap=groups["gap"].max(), limits=groups["limits"].sum()).reset_index()


def plot_bias(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the remaining turn against its prediction, and the line where they are equal.

    Columns: predicted, z2 (length unit), barrier_set (whether a setting gives the barrier).
    """
    ends = np.array([0.5 * table["predicted"].min(), 2 * table["predicted"].max()])
    ax.plot(ends, ends, color=MUTED, linewidth=0.9, linestyle=LINES[1], label="equal")
    hollow: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "none"}
    with_barrier, default = table[table["barrier_set"]], table[~table["barrier_set"]]
    if len(with_barrier):
        look = {"color": BLUE, "label": "Ipopt told to stop at μ", **hollow}
        ax.plot(with_barrier["predicted"], with_barrier["z2"], "o", **look)
    if len(default):
        look = {"color": VERMILION, "markersize": 6, "markeredgewidth": 1.4}
        ax.plot(default["predicted"], default["z2"], "x", label="Ipopt by its defaults", **look)
    ax.set(xscale="log", yscale="log", xlim=tuple(ends), ylim=tuple(ends))
    ax.set(xlabel="(μ R²)^(1/3)  (length unit)", ylabel="right turn left over, z₂ (length unit)")
    log_axis(ax.xaxis)
    log_axis(ax.yaxis)


def plot_left_over(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Draw the remaining turn in radii against the radius; a mark at the bottom means no turn.

    Columns: solver, radius, z2 (length unit).
    """
    looks, names = palette.looks(table["solver"]), palette.names(table["solver"])
    share = table["z2"] / table["radius"]
    foot = 10.0 ** np.floor(np.log10(share[share > 0].min()) - 1) if (share > 0).any() else 1e-8
    for place, solver in enumerate(solver_order(table["solver"].tolist())):
        group = table[table["solver"] == solver].sort_values("radius")
        left = (group["z2"] / group["radius"]).clip(lower=foot)
        # Shift each solver a little, since solvers without a turn all have marks at the bottom.
        at = group["radius"] * 1.06 ** (place - 2)
        look = looks[solver]
        ax.plot(at, left, marker=look.marker, markersize=4, **look.lines, label=names[solver])
    ax.set(xscale="log", yscale="log", ylim=(foot / 2, None))
    ax.set(xlabel="turning radius R (length unit)", ylabel="right turn left over, z₂ / R")
    log_axis(ax.xaxis)
    log_axis(ax.yaxis, lambda value, _=None: "none" if value < 1.5 * foot else power(value))
    ax.axhline(foot, color=INK, linewidth=0.5)


_FOLLOWS = 0.1  # largest |ratio - 1| that confirms the prediction


def bias_section(results: Results) -> Section | None:
    """The remaining turn against its prediction, and the turn that other methods leave."""
    table = left_over(results)
    table = table[(table["branch"] == "best") & table["z2"].notna()]
    with_barrier = table[table["mu"].notna()]
    if with_barrier.empty:
        return None
    barriers, others = by_barrier(table), without_barrier(table)
    palette = Palette.of_page(results)
    sentences = [
        *(_prediction(with_barrier, barriers), *_default(with_barrier, palette)),
        *_others(others),
    ]
    text = (
        "The shortest path to this target is LS, and the paper's model L(z₁) R(z₂) S(z₃) should "
        "answer with z₂ = 0. There its reduced cost is zero: the length grows only like "
        "z₂³ / (3 R²), so a barrier −μ ln z₂ stops the turn at z₂ = (μ R²)^(1/3), where the "
        f"length is μ / 3 too long. {' '.join(sentences)}"
    )
    compared = table[~table["barrier_set"]]
    blocks: list[Picture | Table] = [_bias_picture(with_barrier)]
    if len(compared):
        blocks.append(_left_over_picture(compared, palette))
    blocks.append(_barrier_table(barriers))
    if len(others):
        blocks.append(_other_table(others))
    lead = (
        "Marks on the dashed line confirm the prediction: how much turn an interior-point solver "
        "leaves in a path that should have none, while its length shows nothing."
    )
    return Section("bias", "The interior-point bias in the segments", text, tuple(blocks), lead)


def _prediction(with_barrier: pd.DataFrame, barriers: pd.DataFrame) -> str:
    deviation, slope = prediction_fit(with_barrier)
    comparison = f"is within a relative {digits(2)(deviation)} of this"
    if deviation > _FOLLOWS:
        away = f"up to a relative {digits(2)(deviation)} away"
        comparison = f"does not follow this everywhere: it is {away}"
    failed = int(barriers["failed"].sum())
    failures = f", though the solver calls {failed} of them failures" if failed else ""
    return (
        f"Over {count(len(with_barrier))} attempts z₂ {comparison}; the slope in logarithms is "
        f"{digits(5)(slope)}{failures}."
    )


def _default(with_barrier: pd.DataFrame, palette: Palette) -> list[str]:
    """One sentence on the radius nearest to 1, if the defaults were tried."""
    row = default_attempt(with_barrier)
    if row is None:
        return []
    (name,) = palette.names([row["solver"]]).values()
    return [
        f"By its defaults {name} stops at μ = {digits(3)(row['mu'])}: at "
        f"R = {row['radius']:g} it leaves z₂ = {digits(4)(row['z2'])} where "
        f"{digits(4)(row['predicted'])} is predicted, while the length is only "
        f"{digits(2)(max(row['gap'], 0.0))} of itself too long and shows nothing."
    ]


def _others(others: pd.DataFrame) -> list[str]:
    if others.empty:
        return []
    joint, split = others[others["joint"]], others[~others["joint"]]
    clauses = []
    if len(joint):
        name = " and ".join(sorted({parse_spec(spec)[0] for spec in joint["solver"]}))
        exact, tried = int(joint["exact"].sum()), int(joint["attempts"].sum())
        clauses.append(
            f"on this model {name} leaves no turn in {exact} of {tried} attempts"
            + (f" and up to {digits(2)(joint['most'].max())} R in the others" * (exact < tried))
        )
    if len(split):
        exact, tried = int(split["exact"].sum()), int(split["attempts"].sum())
        clauses.append(
            "with one turn fixed at zero, as the paper's Algorithm 1 does, the other turn is left "
            f"out exactly in {exact} of {tried}"
        )
    text = "; ".join(clauses)
    return [f"{text[:1].upper()}{text[1:]}."]


def _bias_picture(with_barrier: pd.DataFrame) -> Picture:
    caption = (
        "The turn that Ipopt leaves, against the cube root of barrier times radius squared; one "
        "mark per attempt. On the dashed line they are equal."
    )
    alt = "Turn left over against its prediction"
    return picture("bias", plot_bias, with_barrier, caption=caption, alt=alt, height=3.9, legend=1)


def _left_over_picture(compared: pd.DataFrame, palette: Palette) -> Picture:
    return picture(
        "bias-methods",
        plot_left_over,
        *(compared, palette),
        caption="What methods leave that are told no barrier, in radii; at the foot those that "
        "leave no such turn at all.",
        alt="Turn left over by method and radius",
        height=2.9 + 0.16 * compared["solver"].nunique(),
        legend=1,
    )


def _barrier_table(barriers: pd.DataFrame) -> Table:
    table = barriers.assign(by=barriers["barrier_set"].map({True: "told", False: "its defaults"}))
    shown = (
        *columns(digits(3), mu="μ"),
        *columns(kind="text", by="chosen by"),
        *columns(count, attempts="radii"),
        *columns(digits(5), slope="slope", ratio_low="z₂ / predicted, least", ratio_high="most"),
        *columns(digits(3), excess_low="excess / (μ/3), least", excess_high="most"),
        *columns(count, failed="“failed”"),
    )
    caption = (
        "Ipopt by the barrier that it stops at, over the radii: slope of log z₂ against the "
        "prediction's logarithm, ratio of z₂ to it, and by how much the path is longer than the "
        "shortest, over μ / 3. In quotation marks: attempts that the solver calls failed."
    )
    return Table("bias", caption, table, shown)


def _other_table(others: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, attempts="radii", exact="no turn at all"),
        *columns(digits(2), least="least z₂ / R", most="most", gap="largest gap"),
        *columns(count, limits="stopped by a limit"),
    )
    caption = (
        "Methods that are told no barrier. On the unsplit model (joint) a multiplier of zero gives "
        "an active-set method no reason to put the turn at its bound."
    )
    return Table("bias-methods", caption, others, shown)


TOPIC = Topic("the interior-point bias", bias_section, "bias")
