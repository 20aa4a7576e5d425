"""Work and precision of `turn-rate-qp` from rows."""

from __future__ import annotations

import numpy as np
import pandas as pd

from report.metrics import (
    answerable,
    fitted_order,
    gaps_or_infinity,
    parse_spec,
    success,
    upper_quantile,
)

SOLVER = "turn-rate-qp"
DEFAULTS = {"n": "50", "engine": "piqp"}  # a spec leaves out what it does not change


def work_precision(rows: pd.DataFrame) -> pd.DataFrame:
    """One row an engine and n, from the attempts of `turn-rate-qp`.

    Columns: engine, n, attempts, arrived and success (shares of all attempts), gap and gap_q90
    (quantiles, infinite if that many do not arrive), wall_s (median, s), iterations (median),
    order (p of gap ~ n^-p, up to the engine's least gap).
    """
    parsed = rows["solver"].map(parse_spec)
    own = rows[parsed.map(lambda spec: spec[0] == SOLVER and _steps(spec[1]) > 0).astype(bool)]
    if own.empty:
        return pd.DataFrame()
    settings = own["solver"].map(lambda spec: DEFAULTS | parse_spec(spec)[1])
    own = own.assign(engine=settings.map(lambda s: s["engine"]), n=settings.map(_steps))
    records = [
        _record(str(e), int(n), group)  # type: ignore[call-overload]  # pandas says Hashable
        for (e, n), group in own.groupby(["engine", "n"])
    ]
    frame = pd.DataFrame.from_records(records)
    orders = {engine: _order(own) for engine, own in frame.groupby("engine")}
    return frame.assign(order=frame["engine"].map(orders))


def _order(rows: pd.DataFrame) -> float:
    falling = rows.sort_values("n").reset_index(drop=True)
    falling = falling.loc[: int(falling["gap"].to_numpy().argmin())]
    return fitted_order(falling["n"], falling["gap"])


def _steps(settings: dict[str, str]) -> int:
    """n; 0 if it is no number, as in a row that no solver wrote."""
    text = (DEFAULTS | settings)["n"]
    return int(text) if text.isdecimal() else 0


def _record(engine: str, n: int, rows: pd.DataFrame) -> dict[str, object]:
    gaps = gaps_or_infinity(answerable(rows))
    return {
        "engine": engine,
        "n": n,
        "attempts": len(rows),
        "arrived": float(np.isfinite(gaps).mean()) if gaps.size else float("nan"),
        "success": float(success(rows).mean()),
        "gap": upper_quantile(gaps, 0.5),
        "gap_q90": upper_quantile(gaps, 0.9),
        "wall_s": rows["wall_s"].median(),
        "iterations": rows["iterations"].median(),
    }
