"""Paired tests of two solvers on the same questions, and Holm's correction for many of them.

A cost table is described in `costs`: infinity is a failure, NaN a question not asked. A failure
loses to every right answer, two failures tie, and a pair with NaN is left out. Every question
gives one value per solver: the median over its repeats, which are not independent.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import bdtr, ndtr

from dubins_study.report.statistics.costs import checked_costs
from dubins_study.study.path import FloatArray

# Two ratios of costs are tied if their logarithms agree to this many decimals: far finer than any
# timer, and coarser than the rounding of logarithms.
_TIE_DECIMALS = 12
# Up to this many pairs the signed rank test is exact, as in scipy, but with ties as well: there
# scipy writes out all sign patterns, a tenth of a second for 13 pairs. 2^50 patterns are counted
# exactly.
_EXACT_PAIRS = 50


class PairedTest(NamedTuple):
    """The outcome of a two-sided test of a solver against a rival.

    `pairs` compared questions, of which the solver was cheaper in `wins`, dearer in `losses` and
    equal in `ties`; `p`: the probability of a difference at least as large if there is none.
    """

    pairs: int
    wins: int
    losses: int
    ties: int
    p: float


Test = Callable[[ArrayLike, ArrayLike], PairedTest]


def sign_test(costs: ArrayLike, rival_costs: ArrayLike) -> PairedTest:
    """The exact sign test: are wins and losses equally likely?

    Wins are binomial with 1/2 of wins + losses; ties are left out (Conover 1999, Practical
    Nonparametric Statistics, 3rd ed., sec. 3.4). On costs of 0 (right) and 1 (wrong) it is
    McNemar's exact test of two success rates. It assumes nothing of the sizes of differences.

    Both arrays have shape (n,): costs on the same questions. p is 1 if there are only ties. A
    ValueError if the shapes differ or a cost is negative.
    """
    wins, losses, ties = _counts(*_pairs(costs, rival_costs))
    p = min(1.0, 2 * float(bdtr(min(wins, losses), wins + losses, 0.5)))
    return PairedTest(wins + losses + ties, wins, losses, ties, p)


def wilcoxon_test(costs: ArrayLike, rival_costs: ArrayLike) -> PairedTest:
    """Wilcoxon's signed rank test of the logarithms of cost / rival's cost.

    Ranks the sizes of the logarithms and compares the rank sums of wins and losses, so that a
    tenfold win weighs more than a win by a tenth; a failure has the largest rank. Ties of costs are
    left out, ties of ranks share their mean. Exact up to 50 pairs, above that normal with the
    variance corrected for ties, as in `scipy.stats` (Wilcoxon 1945, "Individual comparisons by
    ranking methods", Biometrics Bull. 1; recommended for two methods on many data sets by Demsar
    2006, J. Mach. Learn. Res. 7, sec. 3.1.3). It assumes that without a difference the logarithms
    are symmetric about 0; the sign test does not.

    Arguments, result and errors are those of `sign_test`.
    """
    mine, rival = _pairs(costs, rival_costs)
    wins, losses, ties = _counts(mine, rival)
    decided = mine != rival
    with np.errstate(divide="ignore"):  # a cost of 0 wins by an infinite factor
        logs = np.round(np.log(mine[decided]) - np.log(rival[decided]), _TIE_DECIMALS)
    finite = np.abs(logs[np.isfinite(logs)])
    largest = (finite.max() if finite.size else 0.0) + 1.0
    logs = np.clip(logs, -largest, largest)
    logs = logs[logs != 0]
    ranks = np.asarray(pd.Series(np.abs(logs)).rank(), dtype=np.float64)  # ties share their mean
    p = _exact_p(ranks, logs > 0) if logs.size <= _EXACT_PAIRS else _normal_p(ranks, logs > 0)
    return PairedTest(wins + losses + ties, wins, losses, ties, p)


def _exact_p(ranks: FloatArray, positive: np.ndarray) -> float:
    """The share of sign patterns whose rank sum is as far from its mean, on either side.

    Patterns are counted by their sum of doubled ranks, which are whole numbers with ties too:
    adding a rank to the patterns so far shifts their counts by it.
    """
    doubled = np.rint(2 * ranks).astype(np.intp)
    total, reached = int(doubled.sum()), int(doubled[positive].sum())
    patterns = np.zeros(total + 1)
    patterns[0] = 1.0
    for rank in doubled:
        patterns[rank:] = patterns[rank:] + patterns[:-rank]
    tail = patterns[: min(reached, total - reached) + 1].sum() / 2.0**ranks.size
    return min(1.0, 2 * float(tail))


def _normal_p(ranks: FloatArray, positive: np.ndarray) -> float:
    """The same share for many pairs, whose rank sum is nearly normal.

    With random signs the sum of the positive ranks has the mean sum(r) / 2 and the variance
    sum(r^2) / 4; ties are in the ranks already. It is `scipy.stats.wilcoxon` in two lines: to
    import scipy.stats takes longer than all tests of a report.
    """
    off = ranks[positive].sum() - ranks.sum() / 2
    return 2 * float(ndtr(-abs(off) / np.sqrt((ranks**2).sum() / 4)))


def holm(p_values: ArrayLike) -> FloatArray:
    """Holm's adjusted p-values: p_(i) becomes the largest of (m - j + 1) p_(j), j <= i; at most 1.

    Rejecting what is at most alpha keeps the chance of any false rejection among all m tests at
    alpha, however the tests depend on each other (Holm 1979, "A simple sequentially rejective
    multiple test procedure", Scand. J. Stat. 6).

    The shape is (m,), in any order; NaN is no test: it stays NaN and is not counted in m.
    """
    p = np.asarray(p_values, dtype=np.float64)
    adjusted = np.full(p.shape, np.nan)
    tests = np.flatnonzero(~np.isnan(p))
    wrong = (p[tests] < 0) | (p[tests] > 1)
    if wrong.any():
        raise ValueError(f"a p-value of {p[tests][wrong][0]:g}: probabilities are between 0 and 1")
    order = tests[np.argsort(p[tests], kind="stable")]
    steps = p[order] * np.arange(order.size, 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return adjusted


def pairwise_tests(
    table: pd.DataFrame, test: Test = wilcoxon_test, base: str | None = None
) -> pd.DataFrame:
    """The test of every pair of solvers, or of each against `base`, with Holm's correction.

    The cost table has one row per question: a test that counts repeats as independent questions
    finds differences that are not there. Against a base fewer tests find more.

    Returns:
        One row per pair; columns solver, rival, pairs, wins, losses, ties (of `solver`), p, p_holm
        (over all rows). Two solvers without a common question have p and p_holm NaN.
    """
    if not table.index.is_unique:
        first = table.index[table.index.duplicated()][0]
        raise ValueError(
            f"question {first!r} has several rows; a test takes one value per question: take the "
            "median over its repeats"
        )
    costs = checked_costs(table)
    if base is not None and base not in costs.columns:
        known = ", ".join(map(str, costs.columns))
        raise ValueError(f"no solver named {base!r} to compare with; choose one of: {known}")
    names = [(base, rival) for rival in costs.columns if rival != base]
    lines = []
    for solver, rival in combinations(costs.columns, 2) if base is None else names:
        outcome = test(costs[solver].to_numpy(), costs[rival].to_numpy())
        p = outcome.p if outcome.pairs else np.nan
        lines.append((solver, rival, *outcome[:-1], p))
    frame = pd.DataFrame(lines, columns=["solver", "rival", *PairedTest._fields])
    return frame.assign(p_holm=holm(frame["p"]))


def _pairs(costs: ArrayLike, rival_costs: ArrayLike) -> tuple[FloatArray, FloatArray]:
    mine, rival = (np.asarray(values, dtype=np.float64) for values in (costs, rival_costs))
    if mine.shape != rival.shape or mine.ndim != 1:
        raise ValueError(
            f"costs of shapes {mine.shape} and {rival.shape}: give one per question to both solvers"
        )
    both = ~(np.isnan(mine) | np.isnan(rival))
    mine, rival = mine[both], rival[both]
    least = min(mine.min(initial=0.0), rival.min(initial=0.0))
    if least < 0:
        raise ValueError(f"a cost of {least:g}: a cost is at least 0; mark a failure as infinite")
    return mine, rival


def _counts(mine: FloatArray, rival: FloatArray) -> tuple[int, int, int]:
    """Wins, losses, ties."""
    wins, losses = int(np.sum(mine < rival)), int(np.sum(mine > rival))
    return wins, losses, mine.size - wins - losses
