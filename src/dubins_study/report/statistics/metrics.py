"""Numbers from rows, or from what `report.data.reduction` makes of them. Pure.

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

from dubins_study.report.data.reduction import EXACT, Reduction
from dubins_study.report.data.spread import Spread
from dubins_study.report.data.tally import SUCCESSES, Tally, success

__all__ = ["SUCCESSES", "success"]

FloatArray = NDArray[np.float64]

VERDICTS = ("optimal", "none exists", "longer", "misses", "none")
# experiments that set variants against each other or ask extreme questions on purpose: each has a
# section of its own, and its rows enter no number pooled over experiments
STUDIES = ("discretisation", "basins", "bias", "convergence", "ladder", "scale", "proofs")
QUESTION = ["experiment", "scenario_id", "branch", "initial_guess"]


def parse_spec(spec: str) -> tuple[str, dict[str, str]]:
    """Name and settings of a solver's spec, e.g. `turn-rate-qp[n=50,engine=piqp]`."""
    match = re.fullmatch(r"([^\[\]]+)(?:\[([^\[\]]*)\])?", spec)
    if match is None:
        return spec, {}
    items = (item.partition("=") for item in (match[2] or "").split(",") if item)
    return match[1], {key.strip(): value.strip() for key, _, value in items}


def solver_order(solvers: Sequence[str]) -> list[str]:
    """Distinct solvers: the closed form first, then by name, variants after their plain solver."""

    def rank(spec: str) -> tuple[bool, str, int, str]:
        name, settings = parse_spec(spec)
        return name != EXACT, name, len(settings), spec

    return sorted(set(solvers), key=rank)


def summary(found: Reduction) -> pd.DataFrame:
    """One row a solver: attempts, counts of each verdict, false claims, wrong basins, times.

    Columns: solver, attempts, one per verdict, success (share of all attempts), false_claims,
    wrong_basins, not_returned (timeout, crashed, raised, ...), wall_s (median, s).
    """
    records = []
    for solver in solver_order(list(found.solvers)):
        own = found.solvers[solver]
        record: dict[str, object] = {"solver": solver, "attempts": own.attempts}
        record |= {verdict: own.count("verdict", verdict) for verdict in VERDICTS}
        record |= {
            "success": own.success / own.attempts,
            "false_claims": own.count("false_claim"),
            "wrong_basins": own.count("wrong_basin"),
            "not_returned": own.attempts - own.count("outcome", "returned"),
            "wall_s": own.spread("wall_s").median,
        }
        records.append(record)
    return pd.DataFrame.from_records(records)


def failures(found: Reduction) -> pd.DataFrame:
    """Attempts without success, grouped by what was said and found, most frequent first.

    Columns: solver, outcome, claim, verdict, said (the backend's status and message), attempts.
    """
    keys = ["solver", "outcome", "claim", "verdict", "said"]
    records = [
        (solver, *kind, number)
        for solver, own in found.solvers.items()
        for kind, number in own.kinds("failure").items()
    ]
    grouped = pd.DataFrame.from_records(records, columns=[*keys, "attempts"])
    return grouped.sort_values(["attempts", *keys], ascending=[False] + [True] * 5)


def gaps(own: Tally, region: str = "all") -> Spread:
    """Gaps of the attempts at questions that have an answer, infinite where none arrived."""
    there = own.kinds("answerable") if region == "all" else [(region,)]
    return own.spread(*(f"gap {name}" for (name,) in there))


def gap_quantiles(
    found: Reduction, quantiles: Sequence[float] = (0.5, 0.9, 0.99, 1.0)
) -> pd.DataFrame:
    """Gap quantiles per solver and region; columns solver, region, attempts, arrived, q50, ..."""
    records = []
    for solver in solver_order(list(found.solvers)):
        own = found.solvers[solver]
        asked = gaps(own).size
        for region in REGIONS:
            there = gaps(own, region)
            if not there.size or (region != "all" and there.size == asked):
                continue  # nothing, or nothing new
            record: dict[str, object] = {"solver": solver, "region": region}
            record |= {"attempts": there.size, "arrived": there.finite / there.size}
            record |= {f"q{100 * q:g}": there.upper(q) for q in quantiles}
            records.append(record)
    return pd.DataFrame.from_records(records)


REGIONS = ("all", "outside", "left disc", "right disc", "circle")


def upper_quantile(values: ArrayLike, q: float) -> float:
    """The least value that a share `q` of all values does not exceed; no interpolation."""
    return Spread.of(values).upper(q)


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
