"""The virtual best solver, and what each solver adds to it.

The virtual best solver gives for every question the cheapest right answer of any solver: an oracle
that knows which solver to choose. A solver that is never quite the best adds nothing to it, however
good it is; one that alone answers a few questions adds much. A cost table is described in
`cost_table`; only the questions put to every solver are used.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.cost_table import shared_questions
from dubins_study.report.statistics.means import penalised


def virtual_best(table: pd.DataFrame) -> pd.Series:
    """The cheapest cost of each question; infinite if no solver answered it.

    Returns:
        Indexed by question, in the unit of the table.
    """
    return shared_questions(table).min(axis=1).rename("virtual best")


def contributions(table: pd.DataFrame, limit: float, factor: float = 2.0) -> pd.DataFrame:
    """What each solver adds to the virtual best solver (VBS).

    The marginal contribution is VBS with all solvers minus VBS without this one (Xu, Hutter, Hoos
    and Leyton-Brown 2012, "Evaluating component solver contributions to portfolio-based algorithm
    selectors", SAT 2012, LNCS 7317), here in two measures: questions answered, and mean cost with
    failures penalised. Two equal solvers each add nothing, since either replaces the other.

    Args:
        table: a cost table.
        limit: the limit of an attempt, in the unit of the table; a later answer is a failure.
        factor: what a failure costs, in limits.
    Returns:
        Indexed by solver. best: share of questions for which it is the cheapest (k solvers with
        equal costs count 1/k each; the sum is the share that anyone answered). alone: share of
        questions that only it answered. cost_added: mean penalised cost of the VBS without it
        minus that of the VBS, in the unit of the table, at least 0; without any other solver all
        questions fail. NaN if there are no questions.
    Raises:
        ValueError: if the limit or the factor is out of range.
    """
    costs = shared_questions(table)
    priced = penalised(costs, limit, factor).to_numpy()
    answered = costs.to_numpy() <= limit
    columns = costs.columns.rename("solver")
    if not priced.size:
        return pd.DataFrame(np.nan, columns, ["best", "alone", "cost_added"])
    least = priced.min(axis=1, keepdims=True)
    cheapest = answered & (priced == least)
    best = cheapest / np.maximum(cheapest.sum(axis=1, keepdims=True), 1)
    alone = answered & (answered.sum(axis=1, keepdims=True) == 1)
    # Without one solver the least cost stays, but where it was that solver's: then the second does.
    nobody = np.full((len(priced), 1), factor * limit)
    second = np.sort(np.hstack([priced, nobody]), axis=1)[:, 1:2]
    added = np.where(priced == least, second - least, 0.0)
    return pd.DataFrame(
        {"best": best.mean(axis=0), "alone": alone.mean(axis=0), "cost_added": added.mean(axis=0)},
        columns,
    )
