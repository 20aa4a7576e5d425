"""Numbers from rows. Pure: every function takes frames and gives new ones.

A failed attempt stays in every denominator: shares are of all attempts, and a quantile of the gap
counts an attempt without one as infinitely far off.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

SUCCESSES = ("optimal", "none exists")
VERDICTS = ("optimal", "none exists", "longer", "misses", "none")
# experiments that set variants against each other or ask extreme questions on purpose: each has a
# section of its own, and its rows enter no number pooled over experiments
STUDIES = ("discretisation", "basins", "bias", "convergence", "ladder", "scale", "proofs")
QUESTION = ["experiment", "scenario_id", "branch", "start"]
_FIRST = ("analytic", "slsqp", "ipopt", "turn-rate-qp")


def parse_spec(spec: str) -> tuple[str, dict[str, str]]:
    """Name and settings of a solver's spec, e.g. `turn-rate-qp[n=50,engine=piqp]`."""
    match = re.fullmatch(r"([^\[\]]+)(?:\[([^\[\]]*)\])?", spec)
    if match is None:
        return spec, {}
    items = (item.partition("=") for item in (match[2] or "").split(",") if item)
    return match[1], {key.strip(): value.strip() for key, _, value in items}


def solver_order(solvers: Sequence[str]) -> list[str]:
    """Distinct solvers: the closed form first, variants after their plain solver."""

    def rank(spec: str) -> tuple[int, str, int, str]:
        name, settings = parse_spec(spec)
        place = _FIRST.index(name) if name in _FIRST else len(_FIRST)
        return place, name, len(settings), spec

    return sorted(set(solvers), key=rank)


def success(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether the check found the attempt's answer right."""
    return rows["verdict"].isin(SUCCESSES)


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """One row a solver: attempts, counts of each verdict, false claims, wrong basins, times.

    Columns: solver, attempts, one per verdict, success (share of all attempts), false_claims,
    wrong_basins, not_returned (timeout, crashed, raised, ...), wall_s (median, s).
    """
    records = []
    for solver in solver_order(rows["solver"].tolist()):
        own = rows[rows["solver"] == solver]
        record: dict[str, object] = {"solver": solver, "attempts": len(own)}
        record |= {verdict: int((own["verdict"] == verdict).sum()) for verdict in VERDICTS}
        record |= {
            "success": float(success(own).mean()),
            "false_claims": int(own["false_claim"].sum()),
            "wrong_basins": int(own["wrong_basin"].sum()),
            "not_returned": int((own["outcome"] != "returned").sum()),
            "wall_s": float(own["wall_s"].median()),
        }
        records.append(record)
    return pd.DataFrame.from_records(records)


def gist(message: str) -> str:
    """A message without its numbers and repetitions, so that like messages count as one."""
    parts = [re.sub(r"\d[\d.]*(?:[eE][+-]?\d+)?", "#", part) for part in message.split("; ")]
    return "; ".join(dict.fromkeys(parts))[:160]


def failures(rows: pd.DataFrame) -> pd.DataFrame:
    """Attempts without success, grouped by what was said and found, most frequent first.

    Columns: solver, outcome, claim, verdict, said (the backend's status and message), attempts.
    """
    bad = rows[~success(rows)]
    said = bad["message"].fillna("").where(bad["message"].fillna("") != "", bad["native_status"])
    bad = bad.assign(said=said.fillna("").map(gist))
    keys = ["solver", "outcome", "claim", "verdict", "said"]
    grouped = bad.groupby(keys, dropna=False).size().rename("attempts").reset_index()
    return grouped.sort_values(["attempts", *keys], ascending=[False] + [True] * 5)


def answerable(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts at questions that have an answer: those where a gap could be measured.

    Some row of the question names the shortest word; a crashed attempt may not.
    """
    known = rows["word_ref"].notna()
    return rows[known.groupby([rows[key] for key in QUESTION]).transform("any")]


def gaps_or_infinity(rows: pd.DataFrame) -> FloatArray:
    """Gaps, never below zero; infinite for an attempt that did not arrive. Shape (n,)."""
    gaps: FloatArray = rows["gap"].fillna(np.inf).clip(lower=0).to_numpy(dtype=np.float64)
    return gaps


def upper_quantile(values: ArrayLike, q: float) -> float:
    """The least value that a share `q` of all values does not exceed; no interpolation.

    Interpolating towards an infinite gap would make every quantile infinite.
    """
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    if not ordered.size:
        return float("nan")
    place = int(np.ceil(q * ordered.size - 1e-9)) - 1
    return float(ordered[max(0, place)])


def gap_quantiles(
    rows: pd.DataFrame, quantiles: Sequence[float] = (0.5, 0.9, 0.99, 1.0)
) -> pd.DataFrame:
    """Gap quantiles per solver and region; columns solver, region, attempts, arrived, q50, ..."""
    asked = answerable(rows)
    records = []
    for solver in solver_order(asked["solver"].tolist()):
        own = asked[asked["solver"] == solver]
        for region in REGIONS:
            there = own if region == "all" else own[own["region"] == region]
            if there.empty or (region != "all" and len(there) == len(own)):
                continue  # nothing, or nothing new
            gaps = gaps_or_infinity(there)
            record: dict[str, object] = {"solver": solver, "region": region}
            record |= {"attempts": len(there), "arrived": float(np.isfinite(gaps).mean())}
            record |= {f"q{100 * q:g}": upper_quantile(gaps, q) for q in quantiles}
            records.append(record)
    return pd.DataFrame.from_records(records)


REGIONS = ("all", "outside", "left disc", "right disc", "circle")


def share_within(gaps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sorted finite gaps and the share of all attempts within each; both of shape (m,)."""
    finite = np.sort(gaps[np.isfinite(gaps)])
    return finite, np.arange(1, finite.size + 1) / max(1, gaps.size)


def circle_radius(x: float, y: float, heading: float, target_x: float, target_y: float) -> float:
    """The radius at which a turning circle passes through the target: r^2 / (2 |Y|).

    Y is the target's distance to the left of the start heading, not normalised. Infinite for a
    target straight ahead or behind.
    """
    dx, dy = target_x - x, target_y - y
    side = abs(dy * np.cos(heading) - dx * np.sin(heading))
    return float((dx * dx + dy * dy) / (2 * side)) if side > 0 else float("inf")


def fitted_order(n: ArrayLike, gap: ArrayLike, floor: float = 1e-13) -> float:
    """p of gap ~ n^-p by least squares on logarithms; NaN below two distinct n.

    Args:
        n: shape (m,), steps.
        gap: shape (m,); values at or below `floor`, where rounding takes over, are left out.
    """
    steps, gaps = np.asarray(n, dtype=np.float64), np.asarray(gap, dtype=np.float64)
    keep = np.isfinite(gaps) & (gaps > floor)
    if np.unique(steps[keep]).size < 2:
        return float("nan")
    slope, _ = np.polyfit(np.log(steps[keep]), np.log(gaps[keep]), 1)
    return -float(slope)


def runs_of(words: Sequence[str]) -> list[tuple[int, int, str]]:
    """Runs of equal neighbours: (first, past the last, value)."""
    changes = [i for i in range(1, len(words)) if words[i] != words[i - 1]]
    bounds = [0, *changes, len(words)] if words else []
    return [(a, b, words[a]) for a, b in pairwise(bounds)]
