"""Numbers of attempts that several topics use.

Shares are of the questions that a method takes. A failed attempt stays in every denominator. In a
quantile of gaps, an attempt without a gap counts as infinite.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import chain, zip_longest

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.report.data.attempts import EXACT, PROOFS, SUCCESSES, is_true, own_name, presolved
from dubins_study.study import specs

# A number in a spec; digits behind a letter, as in `nlp2`, count too, a sign does not.
_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)")


def parse_spec(spec: str) -> tuple[str, dict[str, str]]:
    """Name and settings of a solver's spec.

    `turn-rate-qp[n=50,engine=piqp]` gives `turn-rate-qp` and `{"n": "50", "engine": "piqp"}`. A
    spec that cannot be parsed is a name without settings.
    """
    try:
        return specs.parse_spec(spec)
    except specs.SolverError:  # of a folder made by another program
        return spec, {}


def natural(text: str) -> tuple[tuple[bool, float, str], ...]:
    """A sort key that orders texts by their numbers.

    `n=20` comes before `n=160`, and 1e-8 before 1e-3.
    """
    parts = _NUMBER.split(text)  # alternates: text, number, text, ..., text
    texts = ((False, 0.0, part) for part in parts[::2])
    numbers = ((True, float(part), part) for part in parts[1::2])
    alternating = chain.from_iterable(zip_longest(texts, numbers))
    return tuple(filter(None, alternating))


def solver_order(solvers: Sequence[str]) -> list[str]:
    """The distinct solvers in the order of tables.

    Plug-ins' solvers come first, then the closed form, then all others by name. Of equal names, the
    solver with fewer settings comes first.
    """

    def rank(spec: str) -> tuple[object, ...]:
        name, settings = parse_spec(spec)
        return not own_name(spec), name != EXACT, natural(name), len(settings), natural(spec), spec

    return sorted(set(solvers), key=rank)


def success(rows: pd.DataFrame) -> pd.Series[bool]:
    """A mask of the attempts whose answer is right.

    The check accepted the answer, and an engine gave it within the limit.
    """
    return rows["verdict"].isin(SUCCESSES) & ~presolved(rows) & ~is_true(rows["late"])


def proof(rows: pd.DataFrame) -> pd.Series:
    """The kind of each attempt's proof, or `none`."""
    proofs = rows["proof"].astype(object)
    return proofs.where(proofs.isin(PROOFS), "none")


def gaps(rows: pd.DataFrame) -> pd.Series:
    """The gaps of attempts at answerable questions.

    A gap is infinite if no path arrived, and at least 0. `rows` needs the columns gap and
    answerable.
    """
    answerable: pd.Series = rows.loc[rows["answerable"], "gap"]
    return answerable.fillna(np.inf).clip(lower=0)


def upper_quantile(values: ArrayLike, q: float) -> float:
    """A quantile without interpolation.

    The smallest value that a share `q` of all values does not exceed; NaN is left out. There is no
    interpolation, since interpolation towards an infinite gap gives infinity (definition 1 of
    Hyndman and Fan 1996, "Sample quantiles in statistical packages").
    """
    numbers = np.asarray(values, dtype=np.float64).ravel()
    ordered = np.sort(numbers[~np.isnan(numbers)])
    if not ordered.size:
        return float("nan")
    # 1e-9 compensates the rounding of q * n.
    return float(ordered[max(0, int(np.ceil(q * ordered.size - 1e-9)) - 1)])


def circle_radius(x: float, y: float, heading: float, target_x: float, target_y: float) -> float:
    """The turning radius whose circle passes through the target.

    It is r^2 / (2 |Y|), where r is the target's distance and Y its offset from the line of the
    start heading. It is infinite for a target straight ahead or behind.
    """
    dx = target_x - x
    dy = target_y - y
    side = abs(dy * np.cos(heading) - dx * np.sin(heading))
    if side > 0:
        return float((dx * dx + dy * dy) / (2 * side))
    return float("inf")


def fitted_order(n: ArrayLike, gap: ArrayLike, floor: float = 1e-13) -> float:
    """The fitted order p of gap ~ n^-p.

    The fit is by least squares on logarithms; NaN if fewer than two different n remain. Both arrays
    have shape (m,); n counts steps. Gaps up to `floor` are left out, since rounding dominates them.
    """
    steps = np.asarray(n, dtype=np.float64)
    gaps = np.asarray(gap, dtype=np.float64)
    keep = np.isfinite(gaps) & (gaps > floor)
    if np.unique(steps[keep]).size < 2:
        return float("nan")
    slope, _ = np.polyfit(np.log(steps[keep]), np.log(gaps[keep]), 1)
    return -float(slope)
