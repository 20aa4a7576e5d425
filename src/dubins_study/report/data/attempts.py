"""Count attempts: verdicts, weights and questions by solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import entry_points
from typing import TypeAlias

import numpy as np
import pandas as pd

from dubins_study.study.scenario_frame import numbers_of
from dubins_study.study.specs import name_of, plugin_file

Mask: TypeAlias = "pd.Series[bool]"  # of rows
# The closed form; its rows fill the maps of the plane.
EXACT = "analytic"
# The verdict on an answer of the presolve counts as a verdict of its own: no engine was asked.
PRESOLVED = "by presolve"
# The same holds for a right answer after the limit, which is a failure.
LATE = "late"
VERDICTS = ("optimal", "none exists", PRESOLVED, "longer", "misses", "none", LATE)
# Neither right nor wrong: the proven interval around the shortest length is too wide to tell. Such
# an attempt is counted apart, and no share counts it.
UNDECIDED = "undecided"
# The outcome of a question that a solver does not take. It was not called, and no share counts it.
UNTAKEN = "unsupported"
# What an interval counts as one trial of a solver: repeats of it, cold and warm starts, and the
# same attempt in another experiment all depend on each other.
TRIAL = ("scenario_id", "branch")
SUCCESSES = ("optimal", "none exists")
PROOFS = ("proved", "bounded", "extremal", "none")
_METHOD = ["formulation", "engine", "guess"]
# With fewer questions no best method is named.
ENOUGH_TO_CHOOSE = 30
# A method with a smaller share of the questions would shrink the set that all methods share.
ENOUGH_ASKED = 0.9


def own_name(spec: str) -> str:
    """The name of a plug-in's solver, without settings.

    A solver of another installed package counts as a plug-in's. For a solver of this package the
    name is empty: `a/my_solver.py:MySolver[guesses=8]` gives `MySolver`, `ipopt[presolve=True]`
    gives an empty text.
    """
    name = name_of(spec)
    if plugin := plugin_file(name):
        return plugin.class_name
    return name if name in _installed() else ""


@cache
def _installed() -> frozenset[str]:
    """Names of solvers that other installed packages register."""
    points = entry_points(group="dubins_study.solvers")
    return frozenset(p.name for p in points if p.dist and p.dist.name != "dubins-study")


def own(specs: Iterable[str]) -> list[str]:
    """The specs of plug-ins' solvers, in the given order.

    Tables list these solvers before all others.
    """
    return [spec for spec in specs if own_name(spec)]


def legs_of(rows: pd.DataFrame) -> pd.Series[int]:
    """The number of legs of each row's scenario.

    A leg ends at each via point. One more ends at the target, or at the start of a closed path. A
    tour that may end at any of its points has as many legs as points.
    """
    via = rows["via_x"].map(lambda via: len(numbers_of("via_x", via) or ()))
    ends = rows["target_x"].notna() | is_true(rows["closed"])
    return (via + ends).astype(int)


def is_true(values: pd.Series) -> Mask:
    """A mask of true values; missing ones are false."""
    return values.eq(True).fillna(False).astype(bool)


def first_true(conditions: Mapping[str, Mask], default: str) -> pd.Series[str]:
    """The name of the first condition that holds.

    `conditions` maps names to masks of the same rows. Rows where none holds have `default`.
    """
    masks = list(conditions.values())
    return pd.Series(np.select(masks, list(conditions), default), masks[0].index)


def presolved(rows: pd.DataFrame) -> Mask:
    """A mask of attempts that the presolve answered correctly.

    The presolve was right that no path exists, and no engine was asked. The column `presolved` may
    be true beside any answer, so the verdict has to be `none exists` too. A wrong answer counts as
    the solver's, whichever part of the solver was wrong.
    """
    return is_true(rows["presolved"]) & is_true(rows["verdict"].eq("none exists"))


def counted(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with counted verdicts and weights.

    In the column `verdict`, a correct answer of the presolve becomes `PRESOLVED`. A right answer
    after the limit becomes `LATE`. Neither is a success of an engine. The column `weight` is added:
    the part of a question that the attempt counts as (`weights`).
    """
    late = is_true(rows["late"]) & rows["verdict"].isin(SUCCESSES)
    verdict = rows["verdict"].mask(presolved(rows), PRESOLVED).mask(late, LATE)
    return rows.assign(verdict=verdict, weight=weights(rows))


def weights(rows: pd.DataFrame) -> pd.Series[float]:
    """The weights of attempts: 1 / attempts per trial.

    Only attempts of one solver at one trial share it. A solver with two right attempts of three has
    2/3 of a question right. The three may be repeats, or one cold and two warm starts.
    """
    trials = rows.groupby(["solver", *TRIAL], observed=True, dropna=False)
    return 1.0 / trials["solver"].transform("size")


def questions(attempts: pd.DataFrame, which: Mask) -> pd.Series[float]:
    """The number of questions in each solver's attempts.

    `which` is a mask of the attempts that count, and the result is indexed by solver. It sums the
    weights of these attempts, and is rounded because its last digits depend on the order of the
    rows.
    """
    return attempts["weight"].where(which, 0.0).groupby(attempts["solver"]).sum().round(6)


def methods(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver with its method.

    Columns solver, formulation, engine, guess. If a solver's rows state several values, these are
    joined by "or", e.g. `none or warm`.
    """
    stated = rows[["solver", *_METHOD]].drop_duplicates().groupby("solver")
    return stated.agg(_joined).reset_index()


def _joined(values: pd.Series[str]) -> str:
    return " or ".join(sorted(values.dropna().unique())) or "not stated"
