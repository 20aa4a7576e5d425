"""What a result belongs to: a formulation, an engine and an initial guess."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.words import FORMULATIONS

# The columns that name a method. Two solvers may differ in other settings alone: the spec says so.
METHOD = ["formulation", "engine", "guess", "solver"]

# Most curves, bars or rows that a panel of a figure holds.
MOST = 10


def by_method(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows by formulation in the order of `FORMULATIONS`, then by engine, guess and solver.

    Args:
        frame: the columns of `METHOD`, and any others; rows of one method keep their order.
    """
    ranks = pd.DataFrame(
        {
            "formulation": _ranks(frame["formulation"], formulation_order(frame["formulation"])),
            "engine": frame["engine"].str.casefold(),
            "guess": frame["guess"],
            "solver": _ranks(frame["solver"], solver_order(frame["solver"].tolist())),
        }
    )
    order = ranks.sort_values(list(ranks.columns), kind="stable").index
    return frame.loc[order].reset_index(drop=True)


def formulation_order(formulations: Sequence[str] | pd.Series) -> list[str]:
    """Distinct formulations in the order of `FORMULATIONS`, unknown ones last by name."""
    given = set(formulations)
    known = [name for name in FORMULATIONS if name in given]
    return known + sorted(given - set(known))


def best_guesses(frame: pd.DataFrame) -> pd.DataFrame:
    """For each formulation and engine, the guess and settings with the most right answers.

    Args:
        frame: the columns of `METHOD`, right_share (NaN if nothing was asked) and wall_s, which
            decides where shares are equal.
    """
    ranked = frame.sort_values(
        ["right_share", "wall_s"], ascending=[False, True], kind="stable", na_position="last"
    )
    return by_method(ranked.drop_duplicates(["formulation", "engine"]))


def best_engines(frame: pd.DataFrame, most: int = MOST) -> pd.DataFrame:
    """The best guess of each engine, and of each formulation at most so many of the best engines.

    Args:
        frame: as for `best_guesses`.
        most: how many engines to keep in each formulation.
    """
    ranked = best_guesses(frame).sort_values(
        ["right_share", "wall_s"], ascending=[False, True], kind="stable", na_position="last"
    )
    return by_method(ranked.groupby("formulation", sort=False).head(most))


def _ranks(values: pd.Series, order: Sequence[str]) -> pd.Series:
    return values.map({value: place for place, value in enumerate(order)})
