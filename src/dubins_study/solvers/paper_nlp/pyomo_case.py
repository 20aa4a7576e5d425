"""The paper's model (4.12) in Pyomo, and its subproblems: whatever is not free is fixed."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.paper_nlp.best_point import Point
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim


def pyomo_model(units: str = "radius") -> Any:
    """Model (4.12) in Pyomo: z[1..3] >= 0 and the target as variables X, Y to be fixed.

    Args:
        units: lengths in turning radii, or as in the paper in the scenario's unit, with the
            radius R = 1 / b as one more variable to be fixed.
    """
    from pyomo.environ import ConcreteModel, Constraint, Objective, Var, cos, sin

    m = ConcreteModel(name="dubins-4.12")
    m.z = Var((1, 2, 3), bounds=(0, None), initialize=1.0)
    m.X = Var(initialize=1.0)
    m.Y = Var(initialize=1.0)
    z1, z2, z3 = m.z[1], m.z[2], m.z[3]
    R: Any = 1.0
    if units == "scenario":
        R = m.R = Var(initialize=1.0)
        z1, z2 = z1 / R, z2 / R
    m.x_end = Constraint(expr=m.X - R * (2 * sin(z1) - sin(z1 - z2)) - z3 * cos(z1 - z2) == 0)
    m.y_end = Constraint(expr=m.Y - R * (1 - 2 * cos(z1) + cos(z1 - z2)) - z3 * sin(z1 - z2) == 0)
    m.length = Objective(expr=m.z[1] + m.z[2] + z3)
    return m


# One model serves all subproblems: everything that differs between them is set anew.
_shared_model = cache(pyomo_model)


def posed(case: Case, guess: FloatArray) -> Any:
    """The Pyomo model of a subproblem, its free lengths at `guess`, shape (3,)."""
    model = _shared_model()
    for i, z in enumerate(model.z.values()):
        z.setub(case.upper[i] if math.isfinite(case.upper[i]) else None)
        z.set_value(guess[i], skip_validation=True)
        z.fixed = i not in case.subproblem.free
    model.X.fix(case.target[0])
    model.Y.fix(case.target[1])
    return model


def no_point(case: Case, claim: Claim, status: str, message: str) -> Point:
    """The point of a run that returned none: all its numbers are NaN."""
    return Point(case.subproblem, np.full(3, np.nan), claim, None, None, None, status, message)
