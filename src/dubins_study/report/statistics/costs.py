"""Cost tables: what each solver paid for each question, their means, ranks and profiles.

The rows of a cost table are questions, its columns solvers, and a value is the cost of a right
answer in any one unit (seconds, function evaluations). Two values are special: infinity is a
question that the solver was asked and did not answer correctly, so that a failure stays in every
denominator; NaN is a question that it was not asked, or whose cost was not counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.study.path import FloatArray

SHIFT_FACTORS = (0.1, 1.0, 10.0)
PENALTIES = (1.0, 2.0, 10.0)
# Relative gaps from 1 to 1e-8, five to a decade as in COCO.
GAP_TARGETS = tuple(10.0 ** (-step / 5) for step in range(41))


def cost_table(
    rows: pd.DataFrame, *, cost: str, right: str, question: Sequence[str]
) -> pd.DataFrame:
    """The cost table of attempts: the median over repeats, infinite unless all repeats are right.

    The column `cost` holds the cost of an attempt in any unit, NaN if not counted; the column
    `right` says whether the answer is right. In the columns of `question`, which tell questions
    apart, a missing value is a value.
    """
    groups = rows.groupby([*question, "solver"], observed=True, dropna=False)
    table = groups.agg(cost=(cost, "median"), right=(right, "all"))
    costs = table["cost"].where(table["right"].astype(bool), np.inf)
    return pd.DataFrame(costs.unstack("solver")).astype(np.float64)


def checked_costs(table: pd.DataFrame) -> pd.DataFrame:
    """The table as doubles; a ValueError if a cost is negative or two columns have one name."""
    if not table.columns.is_unique:
        twice = sorted({str(name) for name in table.columns[table.columns.duplicated()]})
        raise ValueError(f"solvers named twice: {', '.join(twice)}; give each column its own name")
    costs = table.astype(np.float64)
    negative = costs.to_numpy() < 0
    if negative.any():
        value = float(costs.to_numpy()[negative][0])
        raise ValueError(f"a cost of {value:g}: a cost is at least 0; mark a failure as infinite")
    return costs


def shared_questions(table: pd.DataFrame) -> pd.DataFrame:
    """The questions put to every solver: the rows without NaN.

    A joint profile, mean or ranking of solvers that met different questions compares the questions.
    """
    costs = checked_costs(table)
    return costs[costs.notna().all(axis=1)]


def solved_by_all(table: pd.DataFrame) -> pd.DataFrame:
    """The questions that every solver answered correctly."""
    costs = shared_questions(table)
    return pd.DataFrame(costs[np.isfinite(costs.to_numpy()).all(axis=1)])


def shifted_geometric_mean(values: ArrayLike, shift: float) -> float:
    """exp(mean(log(t + shift))) - shift, in the unit of the values.

    Costs far below the shift hardly change it, and a large cost counts by its factor (Achterberg
    2007, Constraint Integer Programming, PhD thesis, TU Berlin, appendix A). With shift 0 it is
    the geometric mean; as the shift grows it tends to the arithmetic mean.

    An infinite cost (a failure) gives infinity, NaN (not asked) is left out, no values give NaN.
    A ValueError if the shift or a value is negative, or the shift is not finite.
    """
    costs = np.asarray(values, dtype=np.float64).ravel()
    costs = costs[~np.isnan(costs)]
    checked_shift(shift, costs)
    if not costs.size:
        return float("nan")
    with np.errstate(divide="ignore"):  # the mean with a cost of 0 and shift 0 is 0
        return float(np.exp(np.mean(np.log(costs + shift))) - shift)


def checked_shift(shift: float, values: FloatArray) -> float:
    """The shift; a ValueError unless it and the costs can be in a shifted geometric mean."""
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

    The limit of an attempt is in the unit of the table. NaN stays NaN.
    """
    if not (np.isfinite(limit) and limit > 0):
        raise ValueError(f"a limit of {limit!r}: a limit is finite and above 0")
    if not (np.isfinite(factor) and factor >= 1):
        raise ValueError(f"a penalty of {factor!r} limits: a failure costs at least 1 limit")
    costs = checked_costs(table)
    return pd.DataFrame(costs.mask(costs > limit, factor * limit))


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
    rank that changes with the shift or the penalty is said to be none. The limit of an attempt is
    in the unit of the table; the shift is by default `chosen_shift` of the questions put to all.

    Indexed by solver. mean: with the shift itself and failures at the limit; rank: 1 is best, equal
    means share the better rank, <NA> if it is none; best and worst: the rank's range.
    """
    shared = shared_questions(table)
    costs = shared.mask(shared > limit, np.inf)  # a late answer is a failure
    shift = chosen_shift(costs) if shift is None else shift
    ranks = pd.concat(
        [
            ranks_of(column_means(penalised(costs, limit, penalty), factor * shift))
            for factor, penalty in product(shift_factors, penalties)
        ],
        axis=1,
    )
    best, worst = ranks.min(axis=1).astype("Int64"), ranks.max(axis=1).astype("Int64")
    means = column_means(penalised(costs, limit), shift)
    return pd.DataFrame(
        {"mean": means, "rank": best.where(best == worst), "best": best, "worst": worst}
    )


def ranks_of(means: pd.Series) -> pd.Series:
    """Ranks, 1 for the smallest; equal means share the better rank, NaN has none (<NA>)."""
    return means.rank(method="min").astype("Int64")


def column_means(table: pd.DataFrame, shift: float) -> pd.Series:
    """The shifted geometric mean of each column, indexed by solver."""
    means = {solver: shifted_geometric_mean(column, shift) for solver, column in table.items()}
    return pd.Series(means, index=table.columns.rename("solver"), dtype=np.float64)


def performance_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Cost divided by that of the cheapest right answer: r_ps = t_ps / min over s of t_ps.

    Infinite where this solver failed, and for all solvers where all failed. Beside a cheapest cost
    of 0 any other cost is infinite; clip evaluations at 1 to prevent that. (Dolan and More 2002,
    "Benchmarking optimization software with performance profiles", Math. Program. 91, sec. 2.)
    The rows are the questions put to every solver.
    """
    costs = shared_questions(table)
    least = costs.min(axis=1)
    ratios = costs.div(least, axis=0)
    return ratios.mask(costs.eq(least, axis=0) & np.isfinite(costs), 1.0).fillna(np.inf)


def performance_profile(table: pd.DataFrame, factors: ArrayLike) -> pd.DataFrame:
    """rho_s(tau): the share of questions that a solver answers within tau times the cheapest cost.

    rho_s(1) is how often it is the cheapest, the limit for large tau how often it is right at all
    (Dolan and More 2002, sec. 2). Adding a solver may change the order of the others: only the
    best curve may be read as "best" (Gould and Scott 2016, "A note on performance profiles for
    benchmarking software", ACM Trans. Math. Softw. 43, article 15). Indexed by factor, tau >= 1.
    """
    return shares_within(performance_ratios(table), factors, "factor")


def shares_within(table: pd.DataFrame, points: ArrayLike, name: str = "cost") -> pd.DataFrame:
    """The share of questions that each solver answers within each cost.

    Of a cost table of function evaluations it is the data profile of More and Wild 2009
    ("Benchmarking derivative-free optimization algorithms", SIAM J. Optim. 20, sec. 2) in plain
    evaluations, without their division by the number of unknowns. A curve does not depend on the
    other solvers. Indexed by the points, which are in the unit of the table and of which `name` is
    the name; shares of the questions put to every solver.
    """
    costs, index = shared_questions(table), pd.Index(np.asarray(points, np.float64), name=name)
    ordered = np.sort(costs.to_numpy(), axis=0)
    shares = [np.searchsorted(column, _reachable(index), "right") for column in ordered.T]
    counts = np.array(shares, dtype=np.float64).reshape(len(costs.columns), len(index)).T
    return pd.DataFrame(counts / len(costs) if len(costs) else np.nan, index, costs.columns)


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
        at: costs at which to give the share of the pairs of the questions put to every solver,
            shape (n,).
        targets: gap targets, shape (m,).
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


def _reachable(points: ArrayLike) -> FloatArray:
    """The points, none infinite: a failure is not reached even within an infinite cost."""
    return np.minimum(np.asarray(points, np.float64), np.finfo(np.float64).max)
