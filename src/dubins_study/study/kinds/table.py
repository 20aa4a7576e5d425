"""Table of kinds, and the kind of each question."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from dubins_study.study.kinds.frozen import FROZEN_PROBLEM
from dubins_study.study.kinds.kind import Kind, Pathless, Reference
from dubins_study.study.kinds.leg import LEG
from dubins_study.study.kinds.pose import POSE
from dubins_study.study.kinds.route import ROUTE
from dubins_study.study.kinds.tour import TOUR
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, Tolerances
from dubins_study.study.words import Order

if TYPE_CHECKING:
    import pandas as pd

    from dubins_study.study.arrays import BoolArray

# The first that matches a question is its kind.
KINDS: tuple[Kind, ...] = (LEG, POSE, ROUTE, TOUR)
PATHLESS: tuple[Pathless, ...] = (FROZEN_PROBLEM,)
EVERY_KIND: tuple[Kind | Pathless, ...] = (*KINDS, *PATHLESS)

PATH_BRANCHES = tuple(dict.fromkeys(chain.from_iterable(kind.branches for kind in KINDS)))
BRANCHES_WITHOUT_PATH = tuple(chain.from_iterable(kind.branches for kind in PATHLESS))
EVERY_BRANCH = (*PATH_BRANCHES, *BRANCHES_WITHOUT_PATH)


def kind_of(scenario: Scenario, branch: str = "best") -> Kind:
    """Kind of a question whose answer is a path.

    If no kind of the scenario has the branch, it is the first kind that the scenario matches.
    """
    return _kind(scenario.given, branch)


@cache  # asked several times a row
def _kind(given: tuple[bool, ...], branch: str) -> Kind:
    matching = [kind for kind in KINDS if kind.fits(given)]
    return next((kind for kind in matching if branch in kind.branches), matching[0])


def pathless_kind_of(branch: str) -> Pathless | None:
    """Kind of a branch that has no path.

    None if the branch has one.
    """
    return next((kind for kind in PATHLESS if branch in kind.branches), None)


def prepare(scenario: Scenario, branch: str) -> None:
    """Load and compile what answering a question needs.

    Call this before the clock of the answer starts.
    """
    if pathless_kind_of(branch) is None:
        kind_of(scenario, branch).prepare()


def branches_of(scenario: Scenario) -> tuple[str, ...]:
    """Branches that a scenario can be asked for."""
    kinds = [kind for kind in EVERY_KIND if kind.matches(scenario)]
    return tuple(chain.from_iterable(kind.branches for kind in kinds))


def rows_of(frame: pd.DataFrame, kind: Kind | Pathless) -> BoolArray:
    """Mask of a checked frame's rows of a kind."""
    rows = np.ones(len(frame), np.bool_)
    for name, needed in kind.fields.items():
        rows &= _GIVEN[name](frame) == needed
    return rows


def _ends_posed(frame: pd.DataFrame) -> BoolArray:
    """Mask of the rows whose final heading is known.

    A closed path ends with its start heading.
    """
    fixed: BoolArray = frame["final_heading"].notna().to_numpy()
    return fixed | (frame["closed"].to_numpy() & frame["heading"].notna().to_numpy())


# For each field of `OPTIONAL`: a mask of a frame's rows, with the rule of `Scenario.given`.
_GIVEN: dict[str, Callable[[pd.DataFrame], BoolArray]] = {
    "via": lambda frame: frame["via_x"].notna().to_numpy(),
    "searched": lambda frame: (frame["via_x"].notna() | frame["heading"].isna()).to_numpy(),
    "final_heading": _ends_posed,
    "via_heading": lambda frame: frame["via_heading"].notna().to_numpy(),
    "free_start": lambda frame: frame["heading"].isna().to_numpy(),
    "order": lambda frame: (frame["order"] == Order.FREE).to_numpy(),
    "closed": lambda frame: frame["closed"].to_numpy(),
}


def reference_of(
    scenario: Scenario, branch: str = "best", tolerances: Tolerances = DEFAULT
) -> Reference:
    """Reference of a scenario's branch.

    No solver's answer enters it.
    """
    return kind_of(scenario, branch).reference(scenario, branch, tolerances)
