"""The turn that a solver leaves where the shortest path has none: numbers.

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
from dubins_study.report.statistics.metrics import FloatArray, fitted_order, parse_spec

# Ipopt's own constants (Waechter and Biegler 2006, sec. 2 and 3): the first barrier, how it falls
# (min of a share of it and a power of it) and its floor, a share of the tolerance
_MU_INIT, _KAPPA, _THETA, _FLOOR = 0.1, 0.2, 1.5, 1 / 11

_ROUNDING = 1e-15  # rad: a turn by less is none


def last_barrier(tol: float) -> float:
    """The barrier at which Ipopt stops by its defaults: the first of its sequence within `tol`."""
    mu = _MU_INIT
    while mu > tol:
        mu = max(_FLOOR * tol, min(_KAPPA * mu, mu**_THETA))
    return mu


def left_over(results: Results) -> pd.DataFrame:
    """Attempts of the study that came back with a path, and the turn to the right in it.

    Args:
        results: with the specs' settings in the manifests.

    Returns:
        The rows with columns z2 (length of the turn to the right, length unit; 0 if it is lost in
        rounding), mu (barrier that the solver stops at; NaN of one that has none), barrier_set
        (whether a setting gives that barrier), joint (whether the model is unsplit), predicted
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
    """The barrier that a spec stops at on the unsplit model; NaN if it is no such solver's."""
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
    """How well z2 is predicted, of attempts of `left_over` that have a barrier.

    Returns:
        The largest |z2 / predicted - 1|, and the slope of log z2 against log predicted.
    """
    predicted, z2 = (with_barrier[name].to_numpy() for name in ("predicted", "z2"))
    return float((with_barrier["ratio"] - 1).abs().max()), slope(predicted, z2)


def default_attempt(with_barrier: pd.DataFrame) -> pd.Series[Any] | None:
    """Of the attempts whose barrier no setting gives the one at the radius nearest to 1."""
    default = with_barrier[~with_barrier["barrier_set"]]
    if default.empty:
        return None
    return default.iloc[int((default["radius"] - 1).abs().to_numpy().argmin())]


def by_barrier(table: pd.DataFrame) -> pd.DataFrame:
    """One row a solver with a barrier, from `left_over`, by falling barrier.

    Columns: solver, mu, barrier_set, attempts, slope (of log z2 against log predicted, over the
    radii), ratio_low, ratio_high (of z2 / predicted), excess_low, excess_high (of the excess of the
    length over mu / 3), failed (attempts that the solver calls failed).
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
    """One row a solver without a known barrier, from `left_over`.

    Columns: solver, joint, attempts, exact (attempts with no turn to the right at all), least and
    most (z2 / R), gap (largest), limits (attempts stopped by a limit).
    """
    others = table[table["mu"].isna()]
    others = others.assign(turn=others["z2"] / others["radius"], limits=others["claim"] == "limit")
    groups = others.assign(exact=others["turn"] == 0).groupby("solver")
    turn, frame = groups["turn"], groups[["joint"]].first().assign(attempts=groups.size())
    frame = frame.assign(exact=groups["exact"].sum(), least=turn.min(), most=turn.max())
    return frame.assign(gap=groups["gap"].max(), limits=groups["limits"].sum()).reset_index()
