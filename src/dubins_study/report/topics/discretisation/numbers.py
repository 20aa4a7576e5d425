"""Work and precision of `turn-rate-qp` from rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.statistics import metrics

SOLVER = "turn-rate-qp"
_QUANTILES = {"gap_q25": 0.25, "gap": 0.5, "gap_q75": 0.75, "gap_q90": 0.9}
Settings = Mapping[str, Mapping[str, Any]]


def work_precision(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """One row per engine and n, from the attempts of `turn-rate-qp`.

    Args:
        rows: attempts.
        settings: spec -> its settings, as a manifest holds them.

    Returns:
        Columns engine (with all settings in the spec except n), n, solver (a spec of the engine's,
        the same at all n), attempts, arrived and success (shares of all attempts), gap and gap_q25,
        gap_q75, gap_q90 (median and quantiles, infinite if too few arrive), wall_s (median, s),
        iterations (median), order (p of gap ~ n^-p, up to the engine's smallest gap).
    """
    steps = {spec: _steps(spec, settings) for spec in rows["solver"].unique()}
    refined = rows[rows["solver"].map(steps) > 0]
    if refined.empty:
        return pd.DataFrame()
    engines = {spec: _engine(spec, settings) for spec in refined["solver"].unique()}
    refined = refined.assign(engine=refined["solver"].map(engines), n=refined["solver"].map(steps))
    frame = _measures(refined).reset_index()
    orders = {engine: _order(group) for engine, group in frame.groupby("engine")}
    specs = refined.groupby("engine")["solver"].min()
    return frame.assign(order=frame["engine"].map(orders), solver=frame["engine"].map(specs))


def _order(rows: pd.DataFrame) -> float:
    falling = rows.sort_values("n").reset_index(drop=True)
    falling = falling.loc[: int(falling["gap"].to_numpy().argmin())]
    return metrics.fitted_order(falling["n"], falling["gap"])


def _steps(spec: str, settings: Settings) -> int:
    """The setting n of a spec; 0 for another solver, or if n is not a number."""
    n = settings.get(spec, {}).get("n")
    return n if metrics.parse_spec(spec)[0] == SOLVER and isinstance(n, int) else 0


def _engine(spec: str, settings: Settings) -> str:
    engine = str(settings.get(spec, {}).get("engine"))
    others = [
        f"{k}={v}" for k, v in metrics.parse_spec(spec)[1].items() if k not in ("n", "engine")
    ]
    return ", ".join([engine, *others])


def _measures(rows: pd.DataFrame) -> pd.DataFrame:
    measured = rows.assign(value=metrics.gaps(rows), success=metrics.success(rows))
    groups = measured.groupby(["engine", "n"])
    arrived = groups["value"].agg(lambda gaps: np.isfinite(gaps.dropna()).mean())
    frame = pd.DataFrame({"attempts": groups.size(), "arrived": arrived})
    frame = frame.assign(success=groups["success"].mean(), wall_s=groups["wall_s"].median())
    for name, q in _QUANTILES.items():
        frame[name] = groups["value"].agg(metrics.upper_quantile, q=q)
    return frame.assign(iterations=groups["iterations"].median())
