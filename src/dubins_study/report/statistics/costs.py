"""Cost tables: means, ranks, profiles and parts.

A cost table has a row per question and a column per solver. A value is the cost of a right answer
in any one unit (seconds, function evaluations). Infinity: the solver was asked this question and
did not answer correctly, so that a failure stays in every denominator. NaN: the solver was not
asked this question, or its cost was not counted.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from dubins_study.report.statistics.methods import Compared

SHIFT_FACTORS = (0.1, 1.0, 10.0)
PENALTIES = (1.0, 2.0, 10.0)
_POINTS = 120  # of a profile


def cost_table(rows: pd.DataFrame, cost: str, question: Sequence[str]) -> pd.DataFrame:
    """The cost table of attempts.

    A value is the median cost over repeats, and infinite unless all repeats are right. The column
    `cost` holds the cost of an attempt in any unit, NaN if not counted. The column `right` says
    whether the answer is right. The columns `question` together identify a question; a missing
    value in them is a value like others.
    """
    groups = rows.groupby([*question, "solver"], observed=True, dropna=False)
    table = groups.agg(cost=(cost, "median"), right=("right", "all"))
    costs = table["cost"].where(table["right"].astype(bool), np.inf)
    return pd.DataFrame(costs.unstack("solver")).astype(np.float64)


def shared_questions(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of a cost table without NaN.

    Every solver was asked these questions. Solvers that met different questions must not be
    compared: a joint profile, mean or ranking would compare the questions.
    """
    return table[table.notna().all(axis=1)].astype(np.float64)


def shifted_geometric_means(table: pd.DataFrame, shift: float) -> pd.Series:
    """Shifted geometric mean of each column.

    exp(mean(log(t + shift))) - shift, in the unit of the table. Costs far below the shift hardly
    change it, and a large cost counts by its factor (Achterberg 2007, Constraint Integer
    Programming, PhD thesis, TU Berlin, appendix A). With shift 0 it is the geometric mean; as the
    shift grows it tends to the arithmetic mean.

    An infinite cost (a failure) gives infinity, NaN (not asked) is left out, no values give NaN.
    Indexed by solver.
    """
    with np.errstate(divide="ignore"):  # the mean with a cost of 0 and shift 0 is 0
        logs = np.log(table.astype(np.float64) + shift)
    means: pd.Series[float] = np.exp(logs.mean()) - shift
    return means.rename_axis("solver")


def chosen_shift(values: ArrayLike) -> float:
    """A shift chosen from the data.

    The lower quartile of the finite costs; 0 if there are none. It is small beside most costs, so
    that it does not dominate a mean, and large beside the noise of a timer. Quote it with the mean,
    and the ranks at other shifts (`ranking`).
    """
    costs = np.asarray(values, dtype=np.float64).ravel()
    finite = costs[np.isfinite(costs)]
    if not finite.size:
        return 0.0
    return float(np.quantile(finite, 0.25))


def penalised(table: pd.DataFrame, limit: float, factor: float = 1.0) -> pd.DataFrame:
    """The cost table with failures at a penalty.

    A failure costs `factor` times the limit, and so does a cost above the limit. `limit` is the
    limit of an attempt, in the unit of the table. NaN stays NaN.
    """
    return pd.DataFrame(table.mask(table > limit, factor * limit))


def ranking(table: pd.DataFrame, limit: float, shift: float) -> pd.DataFrame:
    """Ranks of solvers; missing where they depend on choices.

    The choices are shift and penalty. A rank orders the shifted geometric means of penalised costs,
    over the questions put to all solvers. Each of `SHIFT_FACTORS` (times `shift`) with each of
    `PENALTIES` (times `limit`) gives one ranking. The limit of an attempt and the shift are in the
    unit of the table.

    Indexed by solver. Columns: rank (1 is best, equal means share the better rank, <NA> if the
    rankings differ), best and worst (the ends of the range of ranks).
    """
    costs = shared_questions(table)
    means = {
        (factor, penalty): shifted_geometric_means(penalised(costs, limit, penalty), factor * shift)
        for factor, penalty in itertools.product(SHIFT_FACTORS, PENALTIES)
    }
    # 1 for the smallest; equal means share the better rank, NaN has none (<NA>)
    ranked = {choice: costs_of.rank(method="min") for choice, costs_of in means.items()}
    ranks = pd.DataFrame(ranked).astype("Int64")
    best = ranks.min(axis=1).astype("Int64")
    worst = ranks.max(axis=1).astype("Int64")
    return pd.DataFrame({"rank": best.where(best == worst), "best": best, "worst": worst})


def performance_profile(table: pd.DataFrame) -> pd.DataFrame:
    """Performance profile rho_s(tau) of each solver.

    The share of questions that a solver answers within tau times the least cost. Indexed by tau,
    from 1 to the largest ratio. rho_s(1) is how often it is the cheapest, the limit for large tau
    how often it is right at all (Dolan and More 2002, "Benchmarking optimization software with
    performance profiles", Math. Program. 91, sec. 2). Adding a solver may change the order of the
    others: only the best curve may be read as "best" (Gould and Scott 2016, "A note on performance
    profiles for benchmarking software", ACM Trans. Math. Softw. 43, article 15). Costs are above 0,
    and of the questions put to every solver.
    """
    costs = shared_questions(table)
    ratios = costs.div(costs.min(axis=1), axis=0).fillna(np.inf)  # where all failed
    values = ratios.to_numpy()
    largest = np.max(values[np.isfinite(values)], initial=2.0)
    factors = pd.Index(np.geomspace(1.0, largest, _POINTS), name="factor")
    within = [(values <= factor).mean(axis=0) for factor in factors]
    return pd.DataFrame(within, factors, costs.columns)


# Kinds of cost, in evaluations or seconds. The run that gave the answer is the floor: the engine
# called once, from that guess. Other runs are its restarts and those on other words. The rest lies
# outside of the runs, e.g. polishing the answer.
KINDS = ("winning run", "other runs", "building", "rest")
# The columns of each run, of the winning one, and of the whole attempt.
AMOUNTS = {
    "evaluations": ("subproblem_evaluations", "best_run_evaluations", "evaluations"),
    "seconds": ("subproblem_s", "best_run_s", "wall_s"),
}


def split(compared: Compared) -> dict[str, pd.DataFrame]:
    """Split the costs of right answers by kind.

    One frame comes back for each key of `AMOUNTS`: `evaluations` and `seconds`. A frame has a row
    per attempt, with the columns solver, `KINDS` and total (of the whole attempt). Questions
    without a path are left out, and so are answers whose winning run is not known. A cost is NaN
    where the engine does not count.
    """
    rows = compared.answerable
    rows = rows[rows["right"] & (rows["best_run_s"] > 0)]
    return {amount: _parts(rows, amount).assign(solver=rows["solver"]) for amount in AMOUNTS}


def _parts(rows: pd.DataFrame, amount: str) -> pd.DataFrame:
    """The attempts' costs by kind, and their totals.

    `amount` is a key of `AMOUNTS` and sets the unit. Columns `KINDS` and total.
    """
    runs, best, total = (rows[name] for name in AMOUNTS[amount])
    all_runs = runs.map(np.nansum, na_action="ignore").astype(np.float64)
    parts = pd.DataFrame({"winning run": best.astype(np.float64)})
    parts["other runs"] = (all_runs - best).clip(lower=0.0).fillna(0.0)
    parts["building"] = 0.0
    if amount == "seconds":
        parts["building"] = rows["build_s"].fillna(0.0)
    counted = parts.sum(axis=1)
    parts["total"] = np.fmax(total.astype(np.float64), counted)
    parts["rest"] = parts["total"] - counted
    return parts[[*KINDS, "total"]].where(best > 0)
