"""Bootstrap intervals of medians, means and ratios, over scenarios.

The index of a table names the scenario of each row. A resample draws as many scenarios as there
are, with replacement, and takes all rows of each: repeats of one scenario stay together, since they
are not independent (the cluster bootstrap: Davison and Hinkley 1997, Bootstrap Methods and their
Application, sec. 3.8). All solvers see the same resamples, so that a ratio compares like with like.

The interval is the percentile interval (Efron and Tibshirani 1993, An Introduction to the
Bootstrap, ch. 13): quantiles of the statistic over the resamples. It keeps its meaning under any
increasing transformation of the cost, and with infinite costs. The BCa interval needs the
jackknife, which fails for medians (the same book, ch. 11).

An infinite value is a failure and counts as the largest cost; NaN was not measured and is left out.
A resample without any value of a column is left out of that column's quantiles.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pandas as pd

from dubins_study.report.statistics.intervals import checked_level
from dubins_study.report.statistics.means import checked_shift
from dubins_study.study.path import FloatArray

RESAMPLES = 1000
# The counts of all resamples: beyond some 80 MB fewer are drawn, since the interval of so many
# scenarios is narrow and its ends need no third digit.
_MOST_COUNTS = 10**7
_FEWEST_RESAMPLES = 100


def median_intervals(
    table: pd.DataFrame, *, level: float = 0.95, resamples: int | None = None, seed: int = 0
) -> pd.DataFrame:
    """The median of each column, with its interval.

    Args:
        table: rows by solvers, the index naming scenarios; any unit.
        level: confidence level, in (0, 1).
        resamples: number of resamples; None: `RESAMPLES`, or fewer of very many scenarios.
        seed: of the resamples; one seed gives the same resamples in every function.
    Returns:
        Indexed by solver; columns estimate, low, high, in the unit of the table. NaN for a column
        without values.
    Raises:
        ValueError: if `level` or `resamples` is out of range.
    """
    weights = _weights(table, resamples, seed)
    return _intervals(table.columns, level, _medians(_values(table), weights))


def mean_intervals(
    table: pd.DataFrame,
    shift: float,
    *,
    level: float = 0.95,
    resamples: int | None = None,
    seed: int = 0,
) -> pd.DataFrame:
    """The shifted geometric mean of each column, with its interval.

    Give penalised costs (`means.penalised`) to keep a failure from making it infinite. Arguments
    and result are those of `median_intervals`; `shift` is that of `means.shifted_geometric_mean`.
    """
    weights = _weights(table, resamples, seed)
    return _intervals(table.columns, level, _means(_values(table), weights, shift))


def average_intervals(
    table: pd.DataFrame, *, level: float = 0.95, resamples: int | None = None, seed: int = 0
) -> pd.DataFrame:
    """The arithmetic mean of each column, with its interval; values may be negative.

    Of a column of successes (0 or 1) it is their share; of differences of successes (-1, 0 or 1)
    the difference of two shares on the same questions. Arguments and result are those of
    `median_intervals`.
    """
    weights = _weights(table, resamples, seed)
    return _intervals(table.columns, level, _averages(_values(table), weights))


def median_ratio_intervals(
    table: pd.DataFrame,
    base: str,
    *,
    level: float = 0.95,
    resamples: int | None = None,
    seed: int = 0,
) -> pd.DataFrame:
    """The median of each column divided by the median of column `base`, with its interval.

    Both medians are over the rows that have a value in both columns. Infinity by infinity and 0 by
    0 are not determined: such an estimate is NaN, and such a resample counts as 0 for the lower end
    and as infinity for the upper one. Arguments and result are those of `median_intervals`, but
    that a ratio has no unit.
    """
    weights = _weights(table, resamples, seed)
    values, rival = _pairs(table, base)
    above, below = _medians(values, weights), _medians(rival, weights)
    return _intervals(table.columns, level, *_ratio_bounds(above, below))


def mean_ratio_intervals(
    table: pd.DataFrame,
    base: str,
    shift: float,
    *,
    level: float = 0.95,
    resamples: int | None = None,
    seed: int = 0,
) -> pd.DataFrame:
    """The shifted geometric mean of each column divided by that of `base`, with its interval.

    As `median_ratio_intervals`; `shift` is that of `means.shifted_geometric_mean`.
    """
    weights = _weights(table, resamples, seed)
    values, rival = _pairs(table, base)
    above, below = _means(values, weights, shift), _means(rival, weights, shift)
    return _intervals(table.columns, level, *_ratio_bounds(above, below))


@lru_cache(maxsize=8)
def scenario_counts(scenarios: int, resamples: int = RESAMPLES, seed: int = 0) -> FloatArray:
    """How often each resample holds each scenario.

    Args:
        scenarios: how many there are.
        resamples: how many resamples to draw.
        seed: of numpy's default generator.
    Returns:
        Shape (resamples, scenarios), whole numbers; each line adds up to `scenarios`.
    Raises:
        ValueError: if `resamples` is below 1.
    """
    if resamples < 1:
        raise ValueError(f"{resamples} resamples: draw at least 1, e.g. {RESAMPLES}")
    if not scenarios:
        return np.zeros((resamples, 0))
    equal = np.full(scenarios, 1 / scenarios)
    counts = np.random.default_rng(seed).multinomial(scenarios, equal, resamples)
    shared = counts.astype(np.float64)
    shared.flags.writeable = False  # the cache hands it to every caller
    return shared


def _values(table: pd.DataFrame) -> FloatArray:
    values: FloatArray = table.to_numpy(dtype=np.float64)
    return values


def _pairs(table: pd.DataFrame, base: str) -> tuple[FloatArray, FloatArray]:
    """The columns, and column `base` beside each; NaN in both where one of the two is NaN."""
    if base not in table.columns:
        known = ", ".join(map(str, table.columns))
        raise ValueError(f"no solver named {base!r} to divide by; choose one of: {known}")
    values = _values(table)
    rival = np.broadcast_to(_values(table[[base]]), values.shape)
    missing = np.isnan(values) | np.isnan(rival)
    return np.where(missing, np.nan, values), np.where(missing, np.nan, rival)


def _weights(table: pd.DataFrame, resamples: int | None, seed: int) -> FloatArray:
    """How often each resample holds each row; the first line is the data, each row once."""
    scenario, names = pd.factorize(table.index)
    affordable = max(_FEWEST_RESAMPLES, _MOST_COUNTS // max(1, len(names)))
    drawn = min(RESAMPLES, affordable) if resamples is None else resamples
    counts = scenario_counts(len(names), drawn, seed)
    return np.vstack([np.ones(len(table)), counts[:, scenario]])


def _medians(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Medians of columns, each value as often as its weight says; shape (lines, columns)."""
    counts = weights.astype(np.int32)
    medians = np.empty((len(weights), values.shape[1]))
    for place, column in enumerate(values.T):
        medians[:, place] = _weighted_medians(column, counts)
    return medians


def _weighted_medians(values: FloatArray, counts: np.ndarray) -> FloatArray:
    """The medians of one column: the mean of the two middle values of each ordered multiset.

    It counts in the values sorted once, instead of sorting every resample.
    """
    order = np.argsort(values, kind="stable")[: np.count_nonzero(~np.isnan(values))]
    if not order.size:
        return np.full(len(counts), np.nan)
    ordered = values[order]
    reached = np.cumsum(counts[:, order], axis=1, dtype=np.int32)
    size = reached[:, -1:]
    middles = []
    for middle in ((size - 1) // 2, size // 2):  # one place if the size is odd
        passed = np.count_nonzero(reached <= middle, axis=1)
        middles.append(ordered[np.minimum(passed, order.size - 1)])
    medians: FloatArray = middles[0] / 2 + middles[1] / 2
    return np.where(size[:, 0] > 0, medians, np.nan)


def _averages(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted arithmetic means, shape (lines, columns)."""
    sums = weights @ np.where(np.isfinite(values), values, 0.0)
    sizes = weights @ (~np.isnan(values)).astype(np.float64)
    for extreme in (np.inf, -np.inf):
        drawn = weights @ (values == extreme).astype(np.float64) > 0
        sums = sums + np.where(drawn, extreme, 0.0)
    with np.errstate(invalid="ignore"):  # 0 / 0: a resample without a value
        means: FloatArray = sums / sizes
    return means


def _means(values: FloatArray, weights: FloatArray, shift: float) -> FloatArray:
    """Weighted shifted geometric means, shape (lines, columns)."""
    with np.errstate(divide="ignore"):  # the mean with a cost of 0 and shift 0 is 0
        logs = np.log(values + checked_shift(shift, values))
    means: FloatArray = np.exp(_averages(logs, weights)) - shift
    return means


def _ratio_bounds(above: FloatArray, below: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The least and the largest value that each ratio may have; they differ if it is undetermined.

    NaN where a side has no value.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = above / below
    undetermined = np.isnan(ratio) & ~np.isnan(above) & ~np.isnan(below)
    return np.where(undetermined, 0.0, ratio), np.where(undetermined, np.inf, ratio)


def _intervals(
    columns: pd.Index, level: float, least: FloatArray, largest: FloatArray | None = None
) -> pd.DataFrame:
    """Estimates from the first lines, and percentile intervals from the other lines."""
    tail = (1 - checked_level(level)) / 2
    largest = least if largest is None else largest
    frame = pd.DataFrame(index=columns.rename("solver"))
    frame["estimate"] = np.where(least[0] == largest[0], least[0], np.nan)
    frame["low"] = _quantiles(least[1:], tail, np.floor)
    frame["high"] = _quantiles(largest[1:], 1 - tail, np.ceil)
    return frame


def _quantiles(statistics: FloatArray, q: float, rounding: np.ufunc) -> FloatArray:
    """A quantile of each column that occurs in it: no interpolation towards infinity."""
    ordered = np.sort(statistics, axis=0)  # NaN last
    last = np.count_nonzero(~np.isnan(ordered), axis=0) - 1
    places = np.clip(rounding(q * last), 0, None).astype(np.intp)
    quantiles: FloatArray = np.take_along_axis(ordered, places[np.newaxis], axis=0)[0]
    return quantiles
