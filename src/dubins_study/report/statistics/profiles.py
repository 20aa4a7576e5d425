"""Profiles: which share of questions a solver answers within a cost.

All are empirical distribution functions; a failure is infinite and stays in the denominator. A cost
table is described in `cost_table`; a joint profile uses the questions put to every solver.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.report.statistics.cost_table import checked_costs, shared_questions
from dubins_study.study.path import FloatArray

# Relative gaps from 1 to 1e-8, five to a decade as in COCO.
GAP_TARGETS = tuple(10.0 ** (-step / 5) for step in range(41))


def ecdf(values: ArrayLike, at: ArrayLike) -> FloatArray:
    """The share of values up to each point; infinite values count, NaN is left out.

    Args:
        values: any shape.
        at: the points, shape (n,).
    Returns:
        Shape (n,): size{v <= x} / size{v}; NaN if there are no values.
    """
    given = np.asarray(values, dtype=np.float64).ravel()
    ordered = np.sort(given[~np.isnan(given)])
    points = np.asarray(at, dtype=np.float64)
    if not ordered.size:
        return np.full(points.shape, np.nan)
    share: FloatArray = np.searchsorted(ordered, points, side="right") / ordered.size
    return share


def steps(values: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """The places at which `ecdf` rises, and the shares reached there.

    Returns:
        Distinct finite values in rising order, and the share of values up to each. Draw them with
        `ax.step(..., where="post")`.
    """
    given = np.asarray(values, dtype=np.float64).ravel()
    places = np.unique(given[np.isfinite(given)])
    return places, ecdf(given, places)


def performance_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Cost divided by that of the cheapest right answer: r_ps = t_ps / min over s of t_ps.

    Infinite where this solver failed, and for all solvers where all failed. Beside a cheapest cost
    of 0 any other cost is infinite; clip evaluations at 1 to prevent that. (Dolan and More 2002,
    "Benchmarking optimization software with performance profiles", Math. Program. 91, sec. 2.)

    Args:
        table: a cost table.
    Returns:
        The questions put to every solver, by solvers; at least 1, no unit.
    """
    costs = shared_questions(table)
    least = costs.min(axis=1)
    ratios = costs.div(least, axis=0)
    return ratios.mask(costs.eq(least, axis=0) & np.isfinite(costs), 1.0).fillna(np.inf)


def performance_profile(table: pd.DataFrame, factors: ArrayLike) -> pd.DataFrame:
    """rho_s(tau): the share of questions that a solver answers within tau times the cheapest cost.

    rho_s(1) is how often it is the cheapest, the limit for large tau how often it is right at all
    (Dolan and More 2002, sec. 2). Adding a solver may change the order of the others: only the
    best curve may be read as "best", see `pairwise_profile`.

    Args:
        table: a cost table.
        factors: tau, shape (n,), at least 1.
    Returns:
        Indexed by factor, one column per solver; shares.
    """
    return _ecdfs(performance_ratios(table), factors, "factor")


def pairwise_profile(
    table: pd.DataFrame, solver: str, rival: str, factors: ArrayLike
) -> pd.DataFrame:
    """The performance profile of two solvers alone, which no third solver can change.

    In a joint profile the second and third curve are compared through the best solver, and may
    change places when it leaves (Gould and Scott 2016, "A note on performance profiles for
    benchmarking software", ACM Trans. Math. Softw. 43, article 15). Arguments and result are those
    of `performance_profile`; over the questions put to both.
    """
    return performance_profile(table[[solver, rival]], factors)


def pairwise_shares(table: pd.DataFrame, factor: float = 1.0) -> pd.DataFrame:
    """rho_s(factor) of every solver (row) in the pairwise profile against every rival (column).

    Each pair has the questions put to both; NaN on the diagonal and where there are none.

    Raises:
        ValueError: if the factor is below 1 or infinite.
    """
    if not 1 <= factor < np.inf:
        raise ValueError(
            f"a factor of {factor!r}: no answer is cheaper than the cheapest, give >= 1"
        )
    costs = checked_costs(table)
    values, names = costs.to_numpy(), costs.columns
    shares = np.full((len(names), len(names)), np.nan)
    for place, column in enumerate(values.T):
        mine = column[:, np.newaxis]
        both = ~(np.isnan(mine) | np.isnan(values))
        within = both & np.isfinite(mine) & (mine <= factor * values)
        with np.errstate(invalid="ignore"):  # 0 / 0: no question was put to both
            shares[place] = within.sum(axis=0) / both.sum(axis=0)
        shares[place, place] = np.nan
    return pd.DataFrame(shares, names.rename("solver"), names.rename("rival"))


def data_profile(
    evaluations: pd.DataFrame, unknowns: float | pd.Series | pd.DataFrame, budgets: ArrayLike
) -> pd.DataFrame:
    """d_s(kappa): the share of questions answered within kappa (n_p + 1) function evaluations.

    n_p + 1 evaluations are what one gradient by differences costs, so kappa counts those (More and
    Wild 2009, "Benchmarking derivative-free optimization algorithms", SIAM J. Optim. 20, sec. 2).
    A curve does not depend on the other solvers.

    Args:
        evaluations: a cost table of function evaluations.
        unknowns: n_p: one number, one for each question (indexed as the table), or a table like
            `evaluations` where formulations differ in it; 0 for a profile in plain evaluations.
        budgets: kappa, shape (n,).
    Returns:
        Indexed by budget, one column per solver; shares of the questions put to every solver.
    Raises:
        ValueError: if a number of unknowns is missing or negative.
    """
    costs = shared_questions(evaluations)
    if isinstance(unknowns, pd.DataFrame):
        sizes = unknowns.reindex(index=costs.index, columns=costs.columns)
    elif isinstance(unknowns, pd.Series):
        each = unknowns.reindex(costs.index).to_numpy(dtype=np.float64)
        sizes = pd.DataFrame(dict.fromkeys(costs.columns, each), costs.index)
    else:
        sizes = pd.DataFrame(float(unknowns), costs.index, costs.columns)
    if not (sizes >= 0).all(axis=None):
        raise ValueError("unknowns: give each question a number that is at least 0")
    return _ecdfs(costs / (sizes + 1), budgets, "budget")


def target_ecdf(
    gaps: pd.DataFrame,
    costs: pd.DataFrame,
    at: ArrayLike,
    targets: ArrayLike = GAP_TARGETS,
) -> pd.DataFrame:
    """The share of (question, target) pairs reached within a cost, over a set of gap targets.

    The runtime distribution of COCO (Hansen, Auger, Ros, Mersmann, Tusar and Brockhoff 2021, "COCO:
    a platform for comparing continuous optimizers in a black-box setting", Optim. Methods Softw.
    36), without its simulated restarts. A run gives one final gap: it reaches every target
    that is at least its gap, at its whole cost, and never reaches the others. It may have passed
    the loose targets earlier, so a curve is a lower bound of the curve with a recorded history.

    Args:
        gaps: questions by solvers; relative; NaN or infinite if no path arrived.
        costs: questions by solvers, the cost of the run whatever its gap, any unit; NaN where the
            solver was not asked. Its rows and columns are those of `gaps`.
        at: costs at which to give the share, shape (n,).
        targets: gap targets, shape (m,).
    Returns:
        Indexed by cost, one column per solver; shares of the pairs of the questions put to every
        solver.
    Raises:
        ValueError: if there is no target, one is NaN, or the two tables differ in shape or names.
    """
    goals = np.sort(np.asarray(targets, dtype=np.float64).ravel())
    if not goals.size or np.isnan(goals).any():
        raise ValueError("gap targets: give at least one, and no NaN")
    if not (gaps.index.equals(costs.index) and gaps.columns.equals(costs.columns)):
        raise ValueError("gaps and costs: give two tables with the same questions and solvers")
    final = gaps.astype(np.float64).fillna(np.inf).to_numpy()
    shared = costs.notna().all(axis=1).to_numpy()
    paid, final = shared_questions(costs), final[shared]
    reached = goals.size - np.searchsorted(goals, final, side="left")
    points = np.asarray(at, dtype=np.float64)
    shares = {}
    for place, (solver, column) in enumerate(paid.items()):
        order = np.argsort(column.to_numpy(), kind="stable")
        pairs = np.concatenate([[0], np.cumsum(reached[order, place])])
        within = np.searchsorted(column.to_numpy()[order], _reachable(points), side="right")
        shares[solver] = pairs[within] / (len(paid) * goals.size) if len(paid) else np.nan
    return pd.DataFrame(shares, pd.Index(points, name="cost"), columns=paid.columns)


def _ecdfs(table: pd.DataFrame, at: ArrayLike, name: str) -> pd.DataFrame:
    """One ECDF per column, indexed by the points."""
    points = np.asarray(at, dtype=np.float64)
    shares = {solver: ecdf(column, _reachable(points)) for solver, column in table.items()}
    return pd.DataFrame(shares, pd.Index(points, name=name), columns=table.columns)


def _reachable(points: FloatArray) -> FloatArray:
    """The points, none infinite: a failure is not reached even within an infinite cost."""
    return np.minimum(points, np.finfo(np.float64).max)
