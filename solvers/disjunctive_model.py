"""The shortest path as a generalised disjunctive program: one disjunct for each word.

A word's end point lies linearly in the sine and cosine of its arcs once it is looked at along the
heading at which the first arc ends. So every disjunct is linear, and the only nonlinear equations
are the four that tie two angles to their sines and cosines, shared by all words.
"""

from __future__ import annotations

import math
from typing import Any

from solvers.model import FULL_TURN

WORDS = ("LS", "RS", "LR", "RL")
TRANSFORMATIONS = ("bigm", "hull")


def gdp_model(X: float, Y: float, words: tuple[str, ...] = WORDS) -> Any:
    """The shortest path among some words, in Pyomo.GDP, not transformed.

    In the vehicle's frame at unit radius, where the start is (0, 0) with heading 0: the least
    z[1] + z[2] + z[3] such that exactly one word leads to the target. z[1] is how far the vehicle
    turns to the left (rad), z[2] how far to the right (rad), z[3] how far it goes straight
    (radii); c[i] and s[i] are the cosine and sine of z[i].

    With T - C the target seen from the centre (0, 1) of the left turning circle, and i = 1 the
    first arc, the first arc ends with heading z[i] at C + (s[i], -c[i]). Along that heading and
    across it, to the right,

        X c[1] + (Y - 1) s[1] = z[3]    X s[1] - (Y - 1) c[1] = 1           (word LS)
        X c[1] + (Y - 1) s[1] = s[2]    X s[1] - (Y - 1) c[1] = 2 - c[2]    (word LR)

    RS and RL are the same in a mirror: -Y for Y, and 1 and 2 change places. The length that a
    word lacks is zero (the paper's Algorithm 1, step 3).

    Args:
        X, Y: target, forward and to the left, in radii.
        words: the disjuncts, out of `WORDS`.

    Returns:
        A `pyomo.environ.ConcreteModel`: variables z, c, s; constraints cosine, sine; disjuncts
        word[w] with constraints absent, along, across; disjunction one_word; objective length.
    """
    from pyomo.environ import ConcreteModel, Constraint, Objective, RangeSet, Var, cos, sin
    from pyomo.gdp import Disjunct, Disjunction

    # No optimum has a full turn in it, and a turn moves the vehicle by its chord, at most 2 radii.
    farthest = math.hypot(X, Y) + 2
    m = ConcreteModel(name="dubins-disjunctive")
    m.turns = RangeSet(2)
    m.z = Var(RangeSet(3), bounds=lambda m, i: (0, farthest if i == 3 else FULL_TURN), initialize=1)
    m.c = Var(m.turns, bounds=(-1, 1), initialize=math.cos(1))
    m.s = Var(m.turns, bounds=(-1, 1), initialize=math.sin(1))
    m.cosine = Constraint(m.turns, rule=lambda m, i: m.c[i] == cos(m.z[i]))
    m.sine = Constraint(m.turns, rule=lambda m, i: m.s[i] == sin(m.z[i]))
    m.word = Disjunct(list(words))
    for word in words:
        _state(m, word, X, Y)
    m.one_word = Disjunction(expr=[m.word[word] for word in words])
    m.length = Objective(expr=m.z[1] + m.z[2] + m.z[3])
    return m


def _state(m: Any, word: str, X: float, Y: float) -> None:
    """Write the constraints of one word into its disjunct."""
    from pyomo.environ import Constraint

    disjunct = m.word[word]
    first, second, side = (1, 2, 1) if word[0] == "L" else (2, 1, -1)
    c, s = m.c[first], m.s[first]
    straight = word[1] == "S"
    disjunct.absent = Constraint(expr=m.z[second if straight else 3] == 0)
    disjunct.along = Constraint(
        expr=X * c + (side * Y - 1) * s == (m.z[3] if straight else m.s[second])
    )
    disjunct.across = Constraint(
        expr=X * s - (side * Y - 1) * c == (1 if straight else 2 - m.c[second])
    )


def transformed(model: Any, transformation: str = "bigm") -> Any:
    """The model as a mixed-integer nonlinear program, in place: what SCIP or an NL file takes.

    Args:
        model: from `gdp_model`.
        transformation: `bigm` or `hull`; every M and every disaggregated bound follows from the
            variables' own bounds.

    Returns:
        The same model; word[w].binary_indicator_var is 1 for the word that is driven.
    """
    from pyomo.environ import TransformationFactory

    TransformationFactory(f"gdp.{transformation}").apply_to(model)
    return model
