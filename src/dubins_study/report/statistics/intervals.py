"""95 % intervals and paired tests.

Wilson's intervals for shares, the cluster bootstrap over scenarios for all else; the sign test, and
Holm's correction for many of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import bdtr

from dubins_study.study.arrays import FloatArray

LEVEL = 0.95
RESAMPLES = 1000
_OF_SEVERAL = 4000
# Most counts of all resamples, some 80 MB. Of more scenarios fewer resamples are drawn: their
# interval is narrow, and its ends need no third digit.
_MOST_COUNTS = 10**7
_FEWEST_RESAMPLES = 100

# Values of shape (rows, columns), weights of shape (resamples, rows) -> (resamples, columns).
Statistic = Callable[[FloatArray, FloatArray], FloatArray]


def wilson_intervals(successes: ArrayLike, trials: ArrayLike, of: int = 1) -> FloatArray:
    """Wilson's score intervals of shares k / n.

    The ends are the shares p with |k/n - p| = z sqrt(p (1 - p) / n), z the normal quantile of (1 +
    0.95) / 2. If the share was chosen among several, as the least or the largest, the level is
    higher: all of them lie in such intervals at once with 95 % (Bonferroni's inequality):

        (k + z^2 / 2  -+  z sqrt(k (n - k) / n + z^2 / 4)) / (n + z^2)

    (Wilson 1927, "Probable inference, the law of succession, and statistical inference", J. Am.
    Stat. Assoc. 22; recommended by Brown, Cai and DasGupta 2001, "Interval estimation for a
    binomial proportion", Stat. Sci. 16, sec. 3). Trials must be independent: count scenarios, not
    the repeats of one. k may be a sum of shares in [0, 1], e.g. of the success rates of scenarios
    over their repeats: their variance is at most p (1 - p), so that the interval is, if anything,
    too wide. Without trials the interval is (0, 1), which the formula tends to.

    k and n have shapes that broadcast; the result has that of k / n and a last axis of 2: low,
    high.
    """
    z = NormalDist().inv_cdf(1 - _tail(of))
    k, n = np.broadcast_arrays(
        np.asarray(successes, dtype=np.float64), np.asarray(trials, dtype=np.float64)
    )
    variance = k * (n - k) / np.where(n > 0, n, 1.0)
    half = z * np.sqrt(variance + z * z / 4)
    low = (k + z * z / 2 - half) / (n + z * z)
    high = (k + z * z / 2 + half) / (n + z * z)
    # With successes alone the upper end is 1, but for rounding.
    return np.stack([low, np.where(k < n, high, 1.0)], axis=-1)


def _tail(intervals: int) -> float:
    """The probability beyond each end of an interval.

    It is 0.025 divided by the number of intervals, so that all of them hold at once with 95 %
    (Bonferroni).
    """
    return (1 - LEVEL) / (2 * intervals)


def scenario_shares(
    rows: pd.DataFrame, *, by: Sequence[str], success: str, scenario: Sequence[str]
) -> pd.DataFrame:
    """The share of successes in each group.

    Repeats of a scenario are one trial. The share is the mean over scenarios of each scenario's
    success rate. Its interval is Wilson's for as many trials as there are scenarios (see
    `wilson_intervals` on fractional successes).

    The columns `by` group attempts, and the columns `scenario` identify a scenario. The column
    `success` says whether an attempt succeeded. The result is indexed by `by`; its columns are
    successes (a sum of rates), trials, share, low, high.
    """
    keys = [*by, *(name for name in scenario if name not in by)]
    rates = (
        rows[success]
        .astype(np.float64)
        .groupby([rows[key] for key in keys], observed=True, dropna=False)
    )
    groups = rates.mean().groupby(level=list(range(len(by))), observed=True, dropna=False)
    frame = pd.DataFrame({"successes": groups.sum(), "trials": groups.size()})
    # A sum of rates may exceed their number by rounding.
    frame["successes"] = frame["successes"].clip(upper=frame["trials"])
    frame["share"] = frame["successes"] / frame["trials"]
    ends = wilson_intervals(frame["successes"], frame["trials"])
    return frame.assign(low=ends[:, 0], high=ends[:, 1])


def bootstrap(
    table: pd.DataFrame,
    statistic: Statistic,
    base: str | None = None,
    *,
    resamples: int | None = None,
    of: int = 1,
) -> pd.DataFrame:
    """A statistic of each column with its percentile interval.

    The method is the cluster bootstrap over scenarios. A resample draws as many scenarios as there
    are, with replacement, and takes all rows of each: repeats of one scenario stay together, since
    they are not independent (Davison and Hinkley 1997, Bootstrap Methods and their Application,
    sec. 3.8). All columns, and all calls, see the same resamples, so that a ratio compares like
    with like. The interval is that of Efron and Tibshirani 1993, An Introduction to the Bootstrap,
    ch. 13: it keeps its meaning under any increasing transformation of the cost, and with infinite
    costs; the BCa interval needs the jackknife, which fails for medians (ch. 11).

    Of medians an infinite value is a failure and counts as the largest cost; NaN was not measured
    and is left out. A resample without any value of a column is left out of its quantiles.

    Args:
        table: rows by solvers, the index naming the scenario of each row; any unit.
        statistic: `medians`, or `averages` or `geometric_means(shift)` of penalised costs.
        base: a column to divide by, without failures. Both statistics are then over the rows that
            have a value in both columns.
        resamples: number of resamples; None: `RESAMPLES`, or fewer of very many scenarios.
        of: of how many intervals this is one: all of them hold at once with 95 % (Bonferroni).

    Returns:
        Indexed by solver; columns estimate, low, high, in the unit of the statistic. NaN for a
        column without values.
    """
    scenario, names = pd.factorize(table.index)
    if resamples is None:
        affordable = max(_FEWEST_RESAMPLES, _MOST_COUNTS // max(1, len(names)))
        resamples = min(_resamples(of), affordable)
    counts = scenario_counts(len(names), resamples)
    # The first line is the data, each row once.
    weights = np.vstack([np.ones(len(table)), counts[:, scenario]])
    values: FloatArray = table.to_numpy(dtype=np.float64)
    if base is None:
        statistics = statistic(values, weights)
    else:
        rival = np.broadcast_to(table[[base]].to_numpy(dtype=np.float64), values.shape)
        missing = np.isnan(values) | np.isnan(rival)
        values = np.where(missing, np.nan, values)
        rival = np.where(missing, np.nan, rival)
        statistics = statistic(values, weights) / statistic(rival, weights)
    return _with_ends(statistics, table.columns.rename("solver"), of)


def bootstrap_of_both(table: pd.DataFrame, engines: Sequence[str], of: int = 1) -> pd.DataFrame:
    """The mean of a table, over scenarios and engines.

    Its interval holds beyond the sampled scenarios and engines: for others of the same sort, too. A
    resample draws scenarios with replacement, draws engines with replacement, and takes the values
    where both meet (Owen 2007, "The pigeonhole bootstrap", Ann. Appl. Stat. 1). The ends are as in
    `bootstrap`. If the mean is one of `of` means, all their intervals hold at once.

    The index of the table names the scenario of each row, and `engines` the engine of each column.
    NaN was not measured. The result has one row (`all`) with the columns estimate, low and high;
    NaN without values.
    """
    values: FloatArray = table.to_numpy(dtype=np.float64)
    measured = ~np.isnan(values)
    weights = []
    # Scenarios are drawn with seed 0, engines with seed 1: the two draws are independent.
    for seed, units in enumerate((table.index, pd.Index(engines))):
        place, names = pd.factorize(units)
        counts = scenario_counts(len(names), _resamples(of), seed)
        weights.append(np.vstack([np.ones(len(place)), counts[:, place]]))
    rows, columns = weights
    with np.errstate(invalid="ignore"):  # 0 / 0: a resample without a value
        sums = ((rows @ np.where(measured, values, 0.0)) * columns).sum(axis=1)
        means = sums / ((rows @ measured) * columns).sum(axis=1)
    return _with_ends(means[:, np.newaxis], pd.Index(["all"]), of)


def _resamples(intervals: int) -> int:
    """The number of resamples for one of some intervals.

    One of several intervals needs more: fewer resamples lie in its smaller tails.
    """
    if intervals == 1:
        return RESAMPLES
    return _OF_SEVERAL


def _with_ends(statistics: FloatArray, names: pd.Index[Any], intervals: int) -> pd.DataFrame:
    """The estimates with the ends of their intervals.

    `statistics` has the shape (1 + resamples, columns). Its first row is of the data themselves,
    the estimate. The result has a row per column, with the columns estimate, low, high. All
    `intervals` of them hold at once (`_tail`).
    """
    frame = pd.DataFrame(statistics, columns=names)
    resampled = frame.iloc[1:]
    # values that occur: no interpolation towards infinity
    low = resampled.quantile(_tail(intervals), interpolation="lower")
    high = resampled.quantile(1 - _tail(intervals), interpolation="higher")
    return pd.DataFrame({"estimate": frame.iloc[0], "low": low, "high": high})


def scenario_counts(scenarios: int, resamples: int, seed: int = 0) -> FloatArray:
    """How often each resample draws each scenario.

    Whole numbers, shape (resamples, scenarios). Equal arguments give equal counts: the seed is
    fixed.
    """
    if not scenarios:
        return np.zeros((resamples, 0))
    equal = np.full(scenarios, 1 / scenarios)
    return np.random.default_rng(seed).multinomial(scenarios, equal, resamples).astype(np.float64)


def medians(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted medians of columns, shape (resamples, columns).

    This is a `Statistic`: each value counts as often as its weight (a whole number) says.
    """
    resamples = (np.repeat(values, counts, axis=0) for counts in weights.astype(int))
    return np.array([pd.DataFrame(resample).median() for resample in resamples])


def averages(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted means of columns, shape (resamples, columns).

    This is a `Statistic` of finite values; NaN is left out. The mean of successes (0 or 1) is their
    share. The mean of differences of successes (-1, 0 or 1) is the difference of two shares on the
    same questions.
    """
    measured = ~np.isnan(values)
    with np.errstate(invalid="ignore"):  # 0 / 0: a resample without a value
        means: FloatArray = (weights @ np.where(measured, values, 0.0)) / (weights @ measured)
    return means


def geometric_means(shift: float) -> Statistic:
    """A `Statistic`: shifted geometric means of finite costs.

    The returned function computes what `costs.shifted_geometric_means` computes, for each resample.
    """

    def means(values: FloatArray, weights: FloatArray) -> FloatArray:
        result: FloatArray = np.exp(averages(np.log(values + shift), weights)) - shift
        return result

    return means


class PairedTest(NamedTuple):
    """The result of a paired test of two solvers.

    The test is two-sided. It compares a solver with a rival on the same questions, by costs (see
    `costs`). `pairs` questions were compared; the solver was cheaper in `wins`, dearer in `losses`
    and equal in `ties`. `p` is the probability of a difference at least as large if there is none;
    it is 1 if there are only ties. A failure loses to every right answer, two failures tie, and a
    pair with NaN is left out. Repeats are not independent: each question has one value, such as
    their median.
    """

    pairs: int
    wins: int
    losses: int
    ties: int
    p: float


def sign_test(costs: ArrayLike, rival_costs: ArrayLike) -> PairedTest:
    """The exact sign test of two solvers' costs.

    Its hypothesis is that wins and losses are equally likely. Wins are binomial with 1/2 of wins +
    losses; ties are left out (Conover 1999, Practical Nonparametric Statistics, 3rd ed., sec. 3.4).
    On costs of 0 (right) and 1 (wrong) it is McNemar's exact test of two success rates. It assumes
    nothing of the sizes of differences.
    """
    first = np.asarray(costs, dtype=np.float64)
    rival = np.asarray(rival_costs, dtype=np.float64)
    pairs = int((~np.isnan(first) & ~np.isnan(rival)).sum())
    wins = int((first < rival).sum())
    losses = int((first > rival).sum())
    p = min(1.0, 2 * float(bdtr(min(wins, losses), wins + losses, 0.5)))
    return PairedTest(pairs, wins, losses, pairs - wins - losses, p)


def holm(p_values: ArrayLike) -> FloatArray:
    """Holm's adjusted p-values.

    p_(i) becomes the largest of (m - j + 1) p_(j), j <= i; at most 1. Rejecting all hypotheses with
    values up to alpha keeps the chance of any false rejection among all m tests at alpha, however
    the tests depend on each other (Holm 1979, "A simple sequentially rejective multiple test
    procedure", Scand. J. Stat. 6).

    The shape is (m,), in any order; NaN is no test: it stays NaN and is not counted in m.
    """
    p = np.asarray(p_values, dtype=np.float64)
    adjusted = np.full(p.shape, np.nan)
    tests = np.flatnonzero(~np.isnan(p))
    order = tests[np.argsort(p[tests], kind="stable")]
    steps = p[order] * np.arange(order.size, 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return adjusted


def paired_tests(table: pd.DataFrame, pairs: Iterable[tuple[str, str]]) -> pd.DataFrame:
    """A sign test for each pair of columns.

    The table is a cost table with one row per question, and a pair is (solver, rival). Columns of
    the result: solver, rival, those of `PairedTest`, and p_holm (Holm's correction over all pairs).
    p and p_holm are NaN for two solvers without a common question.
    """
    lines = [(solver, rival, *sign_test(table[solver], table[rival])) for solver, rival in pairs]
    frame = pd.DataFrame(lines, columns=["solver", "rival", *PairedTest._fields])
    p = frame["p"].where(frame["pairs"] > 0)
    return frame.assign(p=p, p_holm=holm(p))
