"""Spread over seeds: what changes when a question is asked again with another seed.

Stochastic engines draw random numbers, and MIP engines permute rows and break ties by a seed; one
run of either is a sample (Lodi and Tramontani 2013, "Performance variability in mixed-integer
programming", INFORMS TutORials in Operations Research).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from dubins_study.report.statistics.intervals import wilson_intervals


def question_spread(
    rows: pd.DataFrame,
    *,
    question: Sequence[str],
    verdict: str = "verdict",
    right: str = "right",
    cost: str = "wall_s",
    solver: str = "solver",
) -> pd.DataFrame:
    """The spread of each solver at each question, over its repeats.

    Args:
        rows: one row per attempt; repeats of a question differ in their seed alone.
        question: names of the columns that tell questions apart.
        verdict: name of the column with the verdict; a missing one counts as a verdict.
        right: name of the column that says whether the answer is right.
        cost: name of the column with what the attempt cost, right or wrong, in any unit; values
            that are not finite are left out.
        solver: name of the column that tells solvers apart.
    Returns:
        Indexed by solver and question. repeats; success: share of right answers; verdicts: number
        of different ones; changes: whether there are several; median and iqr (upper minus lower
        quartile, interpolated linearly as `scipy.stats.iqr` does) of the cost, in its unit; cv:
        coefficient of variation, the standard deviation (n - 1 in the denominator) over the mean.
        NaN if there are no costs, for cv if there are fewer than two or their mean is 0.
    """
    kept = rows[[solver, *question]].assign(
        verdict=rows[verdict].astype(object).fillna("missing"),
        right=rows[right].astype(np.float64),
        cost=rows[cost].astype(np.float64).where(np.isfinite(rows[cost].astype(np.float64))),
    )
    groups = kept.groupby([solver, *question], observed=True, dropna=False)
    costs = groups["cost"]
    frame = pd.DataFrame({"repeats": groups.size(), "success": groups["right"].mean()})
    frame["verdicts"] = groups["verdict"].nunique()
    frame["changes"] = frame["verdicts"] > 1
    frame["median"] = costs.median()
    frame["iqr"] = costs.quantile(0.75) - costs.quantile(0.25)
    mean = costs.mean()
    frame["cv"] = costs.std(ddof=1) / mean.where(mean > 0)
    return frame


def solver_spread(spread: pd.DataFrame, level: float = 0.95) -> pd.DataFrame:
    """The spread of each solver over the questions that it was asked at least twice.

    Args:
        spread: the result of `question_spread`; its first index level is the solver.
        level: confidence level of the interval, in (0, 1).
    Returns:
        Indexed by solver. questions; repeats: the least number; success: mean success rate of the
        questions; changing: share of questions whose verdict changes with the seed, with Wilson's
        interval changing_low and changing_high; sometimes: share of questions that it answers
        correctly with some seeds and not with others; iqr_relative: median over questions of
        iqr / median; cv: median over questions.
    """
    repeated = spread[spread["repeats"] > 1].assign(
        sometimes=lambda frame: (frame["success"] > 0) & (frame["success"] < 1),
        relative=lambda frame: frame["iqr"] / frame["median"].where(frame["median"] > 0),
    )
    groups = repeated.groupby(level=0, observed=True, dropna=False)
    frame = pd.DataFrame({"questions": groups.size(), "repeats": groups["repeats"].min()})
    frame["success"] = groups["success"].mean()
    changing = groups["changes"].sum()
    frame["changing"] = changing / frame["questions"]
    ends = wilson_intervals(changing, frame["questions"], level)
    frame["changing_low"], frame["changing_high"] = ends[:, 0], ends[:, 1]
    frame["sometimes"] = groups["sometimes"].mean()
    frame["iqr_relative"] = groups["relative"].median()
    frame["cv"] = groups["cv"].median()
    return frame


def seed_success(
    rows: pd.DataFrame, *, repeat: str = "repeat", solver: str = "solver", right: str = "right"
) -> pd.DataFrame:
    """The success rate of each solver had only one repeat been run: lowest, mean and highest.

    Args:
        rows: one row per attempt; every repeat asks the same questions.
        repeat: name of the column with the number of the repeat.
        solver: name of the column that tells solvers apart.
        right: name of the column that says whether the answer is right.
    Returns:
        Indexed by solver; columns repeats, lowest, mean, highest: shares of attempts.
    """
    each = (
        rows[right]
        .astype(np.float64)
        .groupby([rows[solver], rows[repeat]], observed=True, dropna=False)
        .mean()
    )
    groups = each.groupby(level=0, observed=True, dropna=False)
    ends = {"lowest": groups.min(), "mean": groups.mean(), "highest": groups.max()}
    return pd.DataFrame({"repeats": groups.size(), **ends})
