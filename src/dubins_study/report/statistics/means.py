"""Means of costs, and rankings by them.

A cost table is described in `cost_table`: infinity is a failure, NaN a question not asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.report.statistics.cost_table import checked_costs, shared_questions
from dubins_study.study.path import FloatArray

SHIFT_FACTORS = (0.1, 1.0, 10.0)
PENALTIES = (1.0, 2.0, 10.0)


def shifted_geometric_mean(values: ArrayLike, shift: float) -> float:
    """exp(mean(log(t + shift))) - shift, in the unit of the values.

    Costs far below the shift hardly change it, and a large cost counts by its factor (Achterberg
    2007, Constraint Integer Programming, PhD thesis, TU Berlin, appendix A). With shift 0 it is
    the geometric mean; as the shift grows it tends to the arithmetic mean.

    Args:
        values: costs; infinity (a failure) gives infinity, NaN (not asked) is left out.
        shift: in the unit of the values, finite and at least 0.
    Returns:
        The mean; NaN if there are no values.
    Raises:
        ValueError: if the shift or a value is negative, or the shift is not finite.
    """
    costs = np.asarray(values, dtype=np.float64).ravel()
    costs = costs[~np.isnan(costs)]
    checked_shift(shift, costs)
    if not costs.size:
        return float("nan")
    with np.errstate(divide="ignore"):  # the mean with a cost of 0 and shift 0 is 0
        return float(np.exp(np.mean(np.log(costs + shift))) - shift)


def checked_shift(shift: float, values: FloatArray) -> float:
    """The shift, if it and the costs can be in a shifted geometric mean."""
    if not (np.isfinite(shift) and shift >= 0):
        raise ValueError(f"a shift of {shift!r}: a shift is finite and at least 0")
    if (values < 0).any():
        raise ValueError(f"a cost of {values[values < 0][0]:g}: a cost is at least 0")
    return shift


def chosen_shift(values: ArrayLike) -> float:
    """A shift chosen from the data: the lower quartile of the finite costs; 0 if there are none.

    It is small beside most costs, so that it does not dominate a mean, and large beside the noise
    of a timer. Quote it with the mean, and the ranks at other shifts (`ranking`).
    """
    costs = np.asarray(values, dtype=np.float64).ravel()
    finite = costs[np.isfinite(costs)]
    return float(np.quantile(finite, 0.25)) if finite.size else 0.0


def penalised(table: pd.DataFrame, limit: float, factor: float = 1.0) -> pd.DataFrame:
    """Costs in which a failure counts as `factor` times the limit.

    An answer that came after the limit counts as a failure. With the factor 1 a failure is
    penalised at the limit; the arithmetic mean of the result with the factor k is PAR-k (Hutter,
    Hoos, Leyton-Brown and Stuetzle 2009, "ParamILS", J. Artif. Intell. Res. 36; PAR-2 ranks
    the solvers of the SAT competitions).

    Args:
        table: a cost table.
        limit: the limit of an attempt, in the unit of the table; finite, above 0.
        factor: at least 1.
    Returns:
        The table with finite values; NaN stays NaN.
    Raises:
        ValueError: if the limit or the factor is out of range.
    """
    if not (np.isfinite(limit) and limit > 0):
        raise ValueError(f"a limit of {limit!r}: a limit is finite and above 0")
    if not (np.isfinite(factor) and factor >= 1):
        raise ValueError(f"a penalty of {factor!r} limits: a failure costs at least 1 limit")
    costs = checked_costs(table)
    return pd.DataFrame(costs.mask(costs > limit, factor * limit))


def par(table: pd.DataFrame, limit: float, factor: float = 2.0) -> pd.Series:
    """PAR-k of each solver: the arithmetic mean of `penalised` costs (PAR-2 with the factor 2).

    Indexed by solver, in the unit of the table; over the questions that each solver was asked.
    """
    return penalised(table, limit, factor).mean(axis=0)


def in_time(table: pd.DataFrame, limit: float) -> pd.DataFrame:
    """The table, an answer that came after the limit being a failure."""
    costs = checked_costs(table)
    return pd.DataFrame(costs.mask(costs > limit, np.inf))


def solved_by_all(table: pd.DataFrame) -> pd.DataFrame:
    """The questions that every solver answered correctly."""
    costs = shared_questions(table)
    everyone = np.isfinite(costs.to_numpy()).all(axis=1)
    return pd.DataFrame(costs[everyone])


def mean_table(table: pd.DataFrame, limit: float, shift: float | None = None) -> pd.DataFrame:
    """The means of each solver over the questions put to all of them, failures counted three ways.

    Args:
        table: a cost table.
        limit: the limit of an attempt, in the unit of the table.
        shift: of the geometric means; by default `chosen_shift` of the questions put to all.
    Returns:
        Indexed by solver. questions: how many were put to all; solved: how many of them this
        solver answered; par2: arithmetic mean, a failure counts twice the limit; mean_limit:
        shifted geometric mean, a failure counts the limit; common: how many all solvers answered;
        mean_common: shifted geometric mean over those (NaN if there are none), which says nothing
        of failures and leaves out the hard questions.
    """
    costs = in_time(shared_questions(table), limit)
    shift = chosen_shift(costs) if shift is None else shift
    common = solved_by_all(costs)
    at_limit = penalised(costs, limit)
    frame = pd.DataFrame(index=costs.columns.rename("solver"))
    frame["questions"] = len(costs)
    frame["solved"] = np.isfinite(costs).sum(axis=0)
    frame["par2"] = par(costs, limit)
    frame["mean_limit"] = _column_means(at_limit, shift)
    frame["common"] = len(common)
    frame["mean_common"] = _column_means(common, shift)
    return frame


def ranking(
    table: pd.DataFrame,
    limit: float,
    shift: float | None = None,
    *,
    shift_factors: Sequence[float] = SHIFT_FACTORS,
    penalties: Sequence[float] = PENALTIES,
) -> pd.DataFrame:
    """Ranks by the shifted geometric mean of penalised costs, if they do not depend on its choices.

    Each shift factor with each penalty gives a ranking, over the questions put to all solvers. A
    rank that changes with the shift or the penalty is said to be none.

    Args:
        table: a cost table.
        limit: the limit of an attempt, in the unit of the table.
        shift: by default `chosen_shift` of the questions put to all.
        shift_factors: what the shift is multiplied by.
        penalties: what the limit is multiplied by for a failure.
    Returns:
        Indexed by solver. mean: with the shift itself and failures at the limit; rank: 1 is best,
        equal means share the better rank, <NA> if it is none; best and worst: the rank's range.
    """
    costs = in_time(shared_questions(table), limit)
    shift = chosen_shift(costs) if shift is None else shift
    ranks = [
        ranks_of(_column_means(penalised(costs, limit, penalty), factor * shift))
        for factor, penalty in product(shift_factors, penalties)
    ]
    frame = pd.DataFrame({"mean": _column_means(penalised(costs, limit), shift)})
    return frame.join(stable_rank(pd.concat(ranks, axis=1)))


def ranks_of(means: pd.Series) -> pd.Series:
    """Ranks, 1 for the smallest; equal means share the better rank, NaN has none (<NA>)."""
    return means.rank(method="min").astype("Int64")


def stable_rank(ranks: pd.DataFrame) -> pd.DataFrame:
    """The rank that all columns of ranks agree on.

    Returns:
        The index of `ranks`; columns rank (<NA> if the columns differ), best and worst.
    """
    best, worst = ranks.min(axis=1).astype("Int64"), ranks.max(axis=1).astype("Int64")
    return pd.DataFrame({"rank": best.where(best == worst), "best": best, "worst": worst})


def _column_means(table: pd.DataFrame, shift: float) -> pd.Series:
    means = {solver: shifted_geometric_mean(column, shift) for solver, column in table.items()}
    return pd.Series(means, index=table.columns.rename("solver"), dtype=np.float64)
