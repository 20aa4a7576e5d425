"""95 % intervals: Wilson's for shares, and the cluster bootstrap over scenarios for all else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from statistics import NormalDist

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.report.statistics.costs import checked_shift
from dubins_study.study.path import FloatArray

RESAMPLES = 1000
# The counts of all resamples: beyond some 80 MB fewer are drawn, since the interval of that many
# scenarios is narrow and its ends need no third digit.
_MOST_COUNTS, _FEWEST_RESAMPLES = 10**7, 100

# (values of shape (rows, columns), weights of shape (resamples, rows)) -> (resamples, columns).
Statistic = Callable[[FloatArray, FloatArray], FloatArray]


def wilson_intervals(successes: ArrayLike, trials: ArrayLike, level: float = 0.95) -> FloatArray:
    """Wilson's score intervals of shares k / n.

    The ends are the shares p with |k/n - p| = z sqrt(p (1 - p) / n), z the normal quantile of
    (1 + level) / 2:

        (k + z^2 / 2  -+  z sqrt(k (n - k) / n + z^2 / 4)) / (n + z^2)

    (Wilson 1927, "Probable inference, the law of succession, and statistical inference", J. Am.
    Stat. Assoc. 22; recommended by Brown, Cai and DasGupta 2001, "Interval estimation for a
    binomial proportion", Stat. Sci. 16, sec. 3). Trials must be independent: count scenarios, not
    the repeats of one. k may be a sum of shares in [0, 1], e.g. of the success rates of scenarios
    over their repeats: their variance is at most p (1 - p), so that the interval is, if anything,
    too wide. Of no trials nothing is known: the interval is (0, 1), which the formula tends to.

    k and n have shapes that broadcast; the result has that of k / n and a last axis of 2: low,
    high. A ValueError if `level` is outside (0, 1), or k and n are not finite with 0 <= k <= n.
    """
    z = NormalDist().inv_cdf((1 + _checked_level(level)) / 2)
    k, n = np.broadcast_arrays(
        np.asarray(successes, dtype=np.float64), np.asarray(trials, dtype=np.float64)
    )
    wrong = ~(np.isfinite(n) & (k >= 0) & (k <= n))
    if wrong.any():
        raise ValueError(
            f"{k[wrong][0]:g} successes of {n[wrong][0]:g} trials: successes are between 0 and the "
            "trials"
        )
    variance = k * (n - k) / np.where(n > 0, n, 1.0)
    half = z * np.sqrt(variance + z * z / 4)
    low, high = (k + z * z / 2 - half) / (n + z * z), (k + z * z / 2 + half) / (n + z * z)
    # With successes alone the upper end is 1, but for rounding.
    return np.stack([low, np.where(k < n, high, 1.0)], axis=-1)


def wilson_interval(successes: float, trials: float, level: float = 0.95) -> tuple[float, float]:
    """Wilson's score interval of one share; see `wilson_intervals`."""
    low, high = wilson_intervals(successes, trials, level)
    return float(low), float(high)


def scenario_shares(
    rows: pd.DataFrame,
    *,
    by: Sequence[str],
    success: str,
    scenario: Sequence[str],
) -> pd.DataFrame:
    """The share of successes in every group of attempts; repeats of a scenario are one trial.

    The share is the mean over scenarios of each scenario's success rate, the interval Wilson's for
    as many trials as there are scenarios (see `wilson_intervals` on fractional successes).

    Columns `by` make a group of attempts, columns `scenario` tell scenarios apart, the column
    `success` says whether an attempt succeeded. Indexed by `by`; columns successes (a sum of
    rates), trials, share, low, high.
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
    level: float = 0.95,
    resamples: int | None = None,
    seed: int = 0,
) -> pd.DataFrame:
    """A statistic of each column with its percentile interval, by the cluster bootstrap.

    A resample draws as many scenarios as there are, with replacement, and takes all rows of each:
    repeats of one scenario stay together, since they are not independent (Davison and Hinkley 1997,
    Bootstrap Methods and their Application, sec. 3.8). All columns see the same resamples, so that
    a ratio compares like with like. The interval is that of Efron and Tibshirani 1993, An
    Introduction to the Bootstrap, ch. 13: it keeps its meaning under any increasing transformation
    of the cost, and with infinite costs; the BCa interval needs the jackknife, which fails for
    medians (ch. 11).

    An infinite value is a failure and counts as the largest cost; NaN was not measured and is left
    out. A resample without any value of a column is left out of that column's quantiles.

    Args:
        table: rows by solvers, the index naming the scenario of each row; any unit.
        statistic: `medians`, `averages` or `geometric_means(shift)`. Give the last one penalised
            costs, or a failure makes it infinite.
        base: a column to divide by. Both statistics are then over the rows that have a value in
            both columns. Infinity by infinity and 0 by 0 are not determined: such an estimate is
            NaN, and such a resample counts as 0 for the lower end and as infinity for the upper.
        level: confidence level, in (0, 1).
        resamples: number of resamples; None: `RESAMPLES`, or fewer of very many scenarios.
        seed: of the resamples; one seed gives the same resamples in every call.
    Returns:
        Indexed by solver; columns estimate, low, high, in the unit of the statistic. NaN for a
        column without values.
    """
    scenario, names = pd.factorize(table.index)
    affordable = max(_FEWEST_RESAMPLES, _MOST_COUNTS // max(1, len(names)))
    drawn = min(RESAMPLES, affordable) if resamples is None else resamples
    counts = scenario_counts(len(names), drawn, seed)
    # The first line is the data, each row once.
    weights = np.vstack([np.ones(len(table)), counts[:, scenario]])
    values: FloatArray = table.to_numpy(dtype=np.float64)
    if base is None:
        least = largest = statistic(values, weights)
    else:
        if base not in table.columns:
            known = ", ".join(map(str, table.columns))
            raise ValueError(f"no solver named {base!r} to divide by; choose one of: {known}")
        rival = np.broadcast_to(table[[base]].to_numpy(dtype=np.float64), values.shape)
        missing = np.isnan(values) | np.isnan(rival)
        above, below = (
            statistic(np.where(missing, np.nan, side), weights) for side in (values, rival)
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = above / below
        undetermined = np.isnan(ratio) & ~np.isnan(above) & ~np.isnan(below)
        least, largest = (np.where(undetermined, end, ratio) for end in (0.0, np.inf))
    tail = (1 - _checked_level(level)) / 2
    frame = pd.DataFrame(index=table.columns.rename("solver"))
    frame["estimate"] = np.where(least[0] == largest[0], least[0], np.nan)
    frame["low"] = _quantiles(least[1:], tail, np.floor)
    frame["high"] = _quantiles(largest[1:], 1 - tail, np.ceil)
    return frame


@lru_cache(maxsize=8)
def scenario_counts(scenarios: int, resamples: int = RESAMPLES, seed: int = 0) -> FloatArray:
    """How often each resample holds each scenario: whole numbers, shape (resamples, scenarios)."""
    if resamples < 1:
        raise ValueError(f"{resamples} resamples: draw at least 1, e.g. {RESAMPLES}")
    if not scenarios:
        return np.zeros((resamples, 0))
    equal = np.full(scenarios, 1 / scenarios)
    counts = np.random.default_rng(seed).multinomial(scenarios, equal, resamples)
    shared = counts.astype(np.float64)
    shared.flags.writeable = False  # the cache hands it to every caller
    return shared


def medians(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Medians of columns, each value as often as its weight says: a `Statistic`.

    The mean of the two middle values of each ordered multiset. It counts in the values sorted once,
    instead of sorting every resample.
    """
    counts = weights.astype(np.int32)
    result = np.full((len(weights), values.shape[1]), np.nan)
    for place, column in enumerate(values.T):
        order = np.argsort(column, kind="stable")[: np.count_nonzero(~np.isnan(column))]
        if not order.size:
            continue
        reached = np.cumsum(counts[:, order], axis=1, dtype=np.int32)
        size = reached[:, -1:]
        middles = []
        for middle in ((size - 1) // 2, size // 2):  # one place if the size is odd
            passed = np.count_nonzero(reached <= middle, axis=1)
            middles.append(column[order][np.minimum(passed, order.size - 1)])
        result[:, place] = np.where(size[:, 0] > 0, middles[0] / 2 + middles[1] / 2, np.nan)
    return result


def averages(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Arithmetic means of columns; values may be negative: a `Statistic`.

    Of a column of successes (0 or 1) it is their share; of differences of successes (-1, 0 or 1)
    the difference of two shares on the same questions.
    """
    sums = weights @ np.where(np.isfinite(values), values, 0.0)
    sizes = weights @ (~np.isnan(values)).astype(np.float64)
    for extreme in (np.inf, -np.inf):
        drawn = weights @ (values == extreme).astype(np.float64) > 0
        sums = sums + np.where(drawn, extreme, 0.0)
    with np.errstate(invalid="ignore"):  # 0 / 0: a resample without a value
        means: FloatArray = sums / sizes
    return means


def geometric_means(shift: float) -> Statistic:
    """The `Statistic` of `costs.shifted_geometric_mean`."""

    def means(values: FloatArray, weights: FloatArray) -> FloatArray:
        with np.errstate(divide="ignore"):  # the mean with a cost of 0 and shift 0 is 0
            logs = np.log(values + checked_shift(shift, values))
        result: FloatArray = np.exp(averages(logs, weights)) - shift
        return result

    return means


def _quantiles(statistics: FloatArray, q: float, rounding: np.ufunc) -> FloatArray:
    """A quantile of each column that occurs in it: no interpolation towards infinity."""
    ordered = np.sort(statistics, axis=0)  # NaN last
    last = np.count_nonzero(~np.isnan(ordered), axis=0) - 1
    places = np.clip(rounding(q * last), 0, None).astype(np.intp)
    quantiles: FloatArray = np.take_along_axis(ordered, places[np.newaxis], axis=0)[0]
    return quantiles


def _checked_level(level: float) -> float:
    if not 0 < level < 1:
        raise ValueError(f"confidence level {level!r}: a level is between 0 and 1, e.g. 0.95")
    return level
