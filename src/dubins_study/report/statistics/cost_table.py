"""Cost tables: what each solver paid for each question.

Most functions of this folder read one. Its rows are questions, its columns solvers, and a value is
the cost of a right answer in any one unit (seconds, function evaluations). Two values are special:
infinity is a question that the solver was asked and did not answer correctly, so that a failure
stays in every denominator; NaN is a question that it was not asked, or whose cost was not counted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd


def cost_table(
    rows: pd.DataFrame, *, cost: str, right: str, question: Sequence[str], solver: str = "solver"
) -> pd.DataFrame:
    """The cost table of attempts: the median over repeats, infinite unless all repeats are right.

    Args:
        rows: one row per attempt.
        cost: name of the column with the cost of an attempt, in any unit; NaN if not counted.
        right: name of the column that says whether the answer is right.
        question: names of the columns that tell questions apart; a missing value is a value.
        solver: name of the column that tells solvers apart.
    Returns:
        One row per question, one column per solver; the unit of `cost`.
    """
    groups = rows.groupby([*question, solver], observed=True, dropna=False)
    table = groups.agg(cost=(cost, "median"), right=(right, "all"))
    costs = table["cost"].where(table["right"].astype(bool), np.inf)
    return pd.DataFrame(costs.unstack(solver)).astype(np.float64)


def checked_costs(table: pd.DataFrame) -> pd.DataFrame:
    """The table as doubles.

    Raises:
        ValueError: if a cost is negative, or two columns have one name.
    """
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


def one_row_per_question(table: pd.DataFrame) -> pd.DataFrame:
    """The table, if no question occurs twice.

    Raises:
        ValueError: if a question has several rows. A paired test that counts repeats of a question
            as independent questions finds differences that are not there.
    """
    if not table.index.is_unique:
        first = table.index[table.index.duplicated()][0]
        raise ValueError(
            f"question {first!r} has several rows; a test takes one value per question: take the "
            "median over its repeats"
        )
    return checked_costs(table)
