"""A subproblem of the paper's model as a Pyomo model: whatever is not free is fixed."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.paper_nlp.best_point import Point
from dubins_study.solvers.paper_nlp.ipopt import Case, pyomo_model
from dubins_study.study.check.verdict import Claim
from dubins_study.study.path import FloatArray


def posed(case: Case, guess: FloatArray) -> Any:
    """The Pyomo model of a subproblem, its free lengths at `guess`, shape (3,).

    One model serves all: everything that differs between subproblems is set anew.
    """
    model = _model()
    for i, z in enumerate(model.z.values()):
        z.setub(case.upper[i] if math.isfinite(case.upper[i]) else None)
        z.set_value(guess[i], skip_validation=True)
        z.fixed = i not in case.subproblem.free
    model.X.fix(case.target[0])
    model.Y.fix(case.target[1])
    return model


@cache
def _model() -> Any:
    return pyomo_model()


def no_point(case: Case, claim: Claim, status: str, message: str) -> Point:
    """The point of a run that returned none: all its numbers are NaN."""
    return Point(case.subproblem, np.full(3, np.nan), claim, None, None, None, status, message)
