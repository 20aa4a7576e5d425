"""Attempts as they are counted.

The verdict that counts, and each attempt's weight in a trial.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from importlib.metadata import entry_points

import numpy as np
import pandas as pd

from dubins_study.study.scenario_frame import numbers_of
from dubins_study.study.specs import name_of, plugin_file

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
# Two equations that are each off by the tolerance move a path's end, and its length, by a small
# multiple of it.
TOLERANCES = 10.0


def own_name(spec: str) -> str:
    """The name of a plug-in's solver, without settings.

    Empty for a solver of this package. >>> own_name("a/my_solver.py:MySolver[guesses=8]"),
    own_name("ipopt[presolve=True]") ('MySolver', '')
    """
    name = name_of(spec)
    if plugin := plugin_file(name):
        return plugin.class_name
    return name if name in _installed() else ""


@cache
def _installed() -> frozenset[str]:
    """The solvers of other installed packages."""
    points = entry_points(group="dubins_study.solvers")
    return frozenset(p.name for p in points if p.dist and p.dist.name != "dubins-study")


def own(specs: Iterable[str]) -> list[str]:
    """The specs of plug-ins' solvers.

    Tables list these before all others.
    """
    return [spec for spec in specs if own_name(spec)]


def legs_of(rows: pd.DataFrame) -> pd.Series[int]:
    """The number of legs of each row's scenario.

    Each via point has one leg that ends there, and so has the target. A tour that may end at any of
    its points has as many legs as points.
    """
    via = rows["via_x"].map(lambda via: len(numbers_of("via_x", via) or ()))
    ends = rows["target_x"].notna() | is_true(rows["closed"])
    return (via + ends).astype(int)


def is_true(values: pd.Series) -> pd.Series[bool]:
    """Whether each value is true.

    A missing one is not.
    """
    return values.eq(True).fillna(False).astype(bool)


def false_claims(rows: pd.DataFrame) -> pd.Series[bool]:
    """Claims that are false by more than the engine's tolerance.

    The tolerance explains a path that misses by at most ten times as much, relative to the path's
    length, or to a larger radius. A maker's own tolerance is not known, so it explains nothing.
    """
    scale = np.maximum(rows["length"], rows["radius"])
    explained = rows["miss"] <= TOLERANCES * rows["tolerance"] * scale
    return is_true(rows["false_claim"]) & ~(rows["verdict"].eq("misses") & explained)


def presolved(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether the presolve answered each attempt correctly.

    It was right that no path exists, and no engine was asked. A row may say so of any answer. A
    wrong answer counts as the solver's, whichever part of it was wrong.
    """
    return is_true(rows["presolved"]) & is_true(rows["verdict"].eq("none exists"))


def counted(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with counted verdicts and weights.

    `weight` is a part of a question. What the presolve answered correctly is no success of an
    engine, and neither is a late answer.
    """
    late = is_true(rows["late"]) & rows["verdict"].isin(SUCCESSES)
    verdict = rows["verdict"].mask(presolved(rows), PRESOLVED).mask(late, LATE)
    return rows.assign(verdict=verdict, weight=weights(rows))


def weights(rows: pd.DataFrame) -> pd.Series[float]:
    """Weights of attempts: 1 over attempts per trial.

    The solver's own attempts at the same trial. Of two right attempts in three a solver has 2/3 of
    a question right, whether the three are repeats, or a cold and two warm starts.
    """
    trials = rows.groupby(["solver", *TRIAL], observed=True, dropna=False)
    return 1.0 / trials["solver"].transform("size")


def questions(attempts: pd.DataFrame, which: pd.Series[bool]) -> pd.Series[float]:
    """Numbers of questions by solver.

    The weights of the chosen attempts are added. The sum is rounded, since its last digits depend
    on the order.
    """
    return attempts["weight"].where(which, 0.0).groupby(attempts["solver"]).sum().round(6)


def methods(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver with its method.

    Columns solver, formulation, engine, guess; several guesses are joined by or.
    """
    stated = rows[["solver", *_METHOD]].drop_duplicates()
    return stated.groupby("solver").agg(_joined).reset_index()


def _joined(values: pd.Series[str]) -> str:
    return " or ".join(sorted(values.dropna().unique())) or "not stated"
