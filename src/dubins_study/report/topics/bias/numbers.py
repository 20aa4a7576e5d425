"""The turn that a solver leaves where the shortest path has none: numbers.

In the paper's model (4.12) LS is a degenerate minimum: along the feasible curve the length grows
like z2^3 / (3 R^2). A barrier of weight mu adds -mu ln z2, so an interior point that stops at mu
stops at z2 = (mu R^2)^(1/3), where the length is mu / 3 too long (docs/derivation.md, section 7).
Both hold to first order in z2 / R.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.statistics.metrics import FloatArray, parse_spec

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
    keep = np.isfinite(x) & np.isfinite(y) & (x > 0) & (y > 0)
    if np.unique(x[keep]).size < 2:
        return math.nan
    return float(np.polyfit(np.log(x[keep]), np.log(y[keep]), 1)[0])


class Fit(NamedTuple):
    """How well the prediction of the turn left over holds.

    Args:
        deviation: the largest |z2 / predicted - 1|.
        slope: of log z2 against log predicted.
    """

    deviation: float
    slope: float


def prediction_fit(with_barrier: pd.DataFrame) -> Fit:
    """The fit of the attempts of `left_over` that have a barrier."""
    deviation = float((with_barrier["ratio"] - 1).abs().max())
    return Fit(
        deviation, slope(with_barrier["predicted"].to_numpy(), with_barrier["z2"].to_numpy())
    )


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
    records = []
    for solver, group in table[table["mu"].notna()].groupby("solver", sort=False):
        first = group.iloc[0]
        records.append(
            {
                "solver": solver,
                "mu": float(first["mu"]),
                "barrier_set": bool(first["barrier_set"]),
                "attempts": len(group),
                "slope": slope(group["predicted"].to_numpy(), group["z2"].to_numpy()),
                "ratio_low": float(group["ratio"].min()),
                "ratio_high": float(group["ratio"].max()),
                "excess_low": float(group["excess_ratio"].min()),
                "excess_high": float(group["excess_ratio"].max()),
                "failed": int((group["claim"] == "failed").sum()),
            }
        )
    frame = pd.DataFrame.from_records(records)
    return frame if frame.empty else frame.sort_values("mu", ascending=False, ignore_index=True)


def without_barrier(table: pd.DataFrame) -> pd.DataFrame:
    """One row a solver without a known barrier, from `left_over`.

    Columns: solver, joint, attempts, exact (attempts with no turn to the right at all), least and
    most (z2 / R), gap (largest), limits (attempts stopped by a limit).
    """
    records = []
    for solver, group in table[table["mu"].isna()].groupby("solver", sort=True):
        relative = group["z2"] / group["radius"]
        records.append(
            {
                "solver": solver,
                "joint": bool(group["joint"].iloc[0]),
                "attempts": len(group),
                "exact": int((relative == 0).sum()),
                "least": float(relative.min()),
                "most": float(relative.max()),
                "gap": float(group["gap"].max()),
                "limits": int((group["claim"] == "limit").sum()),
            }
        )
    return pd.DataFrame.from_records(records)
