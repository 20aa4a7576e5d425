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

from dubins_study.report.data.results import Results
from dubins_study.report.statistics.metrics import fitted_order, parse_spec
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
