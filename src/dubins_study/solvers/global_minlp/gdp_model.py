"""The shortest path or route as a disjunctive program.

The model: docs/formulations/disjunction.md. Everything is in body coordinates in units of the
radius.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.course import Course
from dubins_study.solvers.minlp_engines.mixed_program import Functions, MixedProgram, Row, Written
from dubins_study.solvers.presolve import WORDS
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import POSE_BRANCHES, TURN

_OF_LEGS = POSE_BRANCHES[1:]  # words of a leg to a given heading; `WORDS` are those to a free one
_THREE_ARCS = 4.0  # radii; points so far apart are joined by no shortest path of three arcs
TRANSFORMATIONS = ("bigm", "hull")
_QUARTER = TWO_PI / 4
# The number of whole turns by which a heading is off is _FEWEST_TURNS plus those of these digits
# whose binaries are 1.
_TURN_DIGITS = (1, 2, 4)
_FEWEST_TURNS = -3

# For each leg the steps (radii) that it may take, by (the point where it begins, the point where it
# ends); 0 is the start: [{(0, 1): step, (0, 2): step}, {(1, 2): step, (2, 1): step}].
Steps = list[dict[tuple[int, int], FloatArray]]

# The least and the largest value of each angle, by leg and name: {(0, "alpha"): (0.0, 6.28), ...}.
Ranges = dict[tuple[int, str], tuple[float, float]]


def steps_in_any_order(course: Course, with_target: bool) -> Steps:
    """Each leg's possible steps if the order is free.

    A leg has a step from each point where it may begin to each other point where it may end. The
    first leg begins at the start. With a target the last leg ends at the last point.
    """
    points = np.vstack((np.zeros(2), np.cumsum(course.steps, axis=0)))
    last = course.legs
    via = list(range(1, last + 1 - with_target))
    # the points where the vehicle may be after 0, 1, 2, ... legs
    passed = [[0], *[via] * len(via)]
    if with_target:
        passed.append([last])
    steps: Steps = []
    for begins, ends in pairwise(passed):
        pairs = product(begins, ends)
        steps.append({(i, j): points[j] - points[i] for i, j in pairs if i != j})
    return steps


def gdp_model(
    course: Course,
    words: tuple[str, ...] = WORDS,
    quadrants: bool = True,
    steps: Steps | None = None,
) -> Any:
    """A course's shortest path in Pyomo.GDP, not transformed.

    Exactly one word holds for each leg. `words` are those of a last leg to a free final heading.
    `steps` are the steps that legs may take, if they are not those of the course. Exactly one step
    holds for each leg.

    The model's variables of a leg:

    - z: the angles `alpha` and `gamma`, by which the leg turns before and after the direction `mu`;
      `mu` itself; and `beta`, half of a middle arc.
    - c and s: the cosines and sines of these angles.
    - q: how far an angle is past the beginning of its quadrant. Without `quadrants` there is no q,
      and the cosines and sines are of the angles themselves.
    - w: the rest of the leg's length beside `alpha` and `gamma`.
    """
    from pyomo.environ import Binary, ConcreteModel, Constraint, Objective, Var, cos, sin
    from pyomo.gdp import Disjunct, Disjunction

    n = course.legs
    steps = steps or [{(leg, leg + 1): step} for leg, step in enumerate(course.steps)]
    away = [[math.hypot(*step) for step in leg_steps.values()] for leg_steps in steps]
    free = [course.last is None and leg == n - 1 for leg in range(n)]
    # each leg's words; three arcs only where its points may be near
    of_leg: list[Sequence[str]] = []
    farthest = []  # the longest that `w` may be
    for distances, is_free in zip(away, free, strict=True):
        # No optimum has a full turn in it, and a turn moves the vehicle by its chord, at most 2
        # radii.
        if is_free:
            of_leg.append(words)
            farthest.append(max(distances) + 2)
        else:
            close = min(distances) < _THREE_ARCS
            of_leg.append([word for word in _OF_LEGS if close or "S" in word])
            farthest.append(max(max(distances) + 4, 2 * TWO_PI))
    ranges: Ranges = {}
    for leg in range(n):
        three_arcs = "RLR" in of_leg[leg]
        lowest = 0.0
        if three_arcs:
            lowest = -TWO_PI / 2
        ranges |= dict.fromkeys(((leg, "alpha"), (leg, "gamma")), (lowest, TWO_PI))
        if leg:
            ranges[leg, "mu"] = 0.0, TWO_PI
        if three_arcs:
            ranges[leg, "beta"] = _QUARTER, TWO_PI / 2
    m = ConcreteModel(name="dubins-disjunctive")
    m.steps = steps
    # a list: Pyomo makes a set of a dict's keys, whose order depends on the process
    angles = list(ranges)
    m.z = Var(angles, bounds=lambda m, *key: ranges[key], initialize=_QUARTER)
    m.c = Var(angles, bounds=(-1, 1), initialize=math.cos(1))
    m.s = Var(angles, bounds=(-1, 1), initialize=math.sin(1))
    m.w = Var(range(n), bounds=lambda m, leg: (0, farthest[leg]), initialize=1)
    # the headings between the legs, and whole turns by which they leave the range of `mu`
    m.theta = Var(range(1, n + (course.last is not None)), bounds=(-2 * TWO_PI, 3 * TWO_PI))
    m.whole = Var(m.theta.index_set(), _TURN_DIGITS, domain=Binary)
    if quadrants:
        _add_quadrants(m, ranges)
    else:
        m.cosine = Constraint(angles, rule=lambda m, *key: m.c[key] == cos(m.z[key]))
        m.sine = Constraint(angles, rule=lambda m, *key: m.s[key] == sin(m.z[key]))
    if max(map(len, steps)) > 1:
        _add_steps(m, steps, away)
    chosen = [(leg, word) for leg in range(n) for word in of_leg[leg]]

    def rule(disjunct: Any, leg: int, word: str) -> None:
        _word(disjunct, leg, word, steps[leg])

    m.word = Disjunct(chosen, rule=rule)
    m.one_word = Disjunction(range(n), rule=lambda m, leg: [m.word[leg, w] for w in of_leg[leg]])
    if course.last is not None:
        last = math.remainder(course.last, TWO_PI)
        m.arrives = Constraint(expr=m.theta[n] - _whole_turns(m, n) == last)
    turned = sum(m.z[leg, name] for leg in range(n) for name in ("alpha", "gamma"))
    m.length = Objective(expr=turned + sum(m.w[leg] for leg in range(n)))
    return m


def _add_steps(m: Any, steps: Steps, away: list[list[float]]) -> None:
    """Add the choice of each leg's step to m.

    The variables `along` and `across` are the step's parts (radii) along the leg's direction and to
    its left. The disjuncts `step` set them for one pair of points each. Three constraints follow:
    `goes_on`, a leg begins where the one before it ends; `once`, each point that the first leg may
    reach is passed once; `straight`, no leg is shorter than its step.
    """
    from pyomo.environ import Constraint, Var
    from pyomo.gdp import Disjunct, Disjunction

    legs = range(len(steps))
    farthest = [max(distances) for distances in away]
    bounds = {leg: (-far, far) for leg, far in enumerate(farthest)}
    m.along = Var(legs, bounds=bounds)
    m.across = Var(legs, bounds=bounds)
    m.first_sine = Var(bounds=(-1, 1))  # of the first leg's direction

    def rule(disjunct: Any, leg: int, begin: int, end: int) -> None:
        cos_mu = m.c[0, "alpha"]
        sin_mu = m.first_sine
        if leg:
            cos_mu = m.c[leg, "mu"]
            sin_mu = m.s[leg, "mu"]
        X, Y = (steps[leg][begin, end] / farthest[leg]).tolist()
        along = m.along[leg] / farthest[leg]
        across = m.across[leg] / farthest[leg]
        disjunct.along = Constraint(expr=X * cos_mu + Y * sin_mu == along)
        disjunct.across = Constraint(expr=Y * cos_mu - X * sin_mu == across)

    m.step = Disjunct([(leg, *ends) for leg in legs for ends in steps[leg]], rule=rule)
    m.one_step = Disjunction(legs, rule=lambda m, leg: [m.step[leg, ends] for ends in steps[leg]])
    places = []
    for leg in legs[1:]:
        begins = {begin for begin, _ in steps[leg]}
        places += [(leg, begin) for begin in begins]

    def goes_on(m: Any, leg: int, place: int) -> Any:
        leaves = sum(m.step[leg, place, :].binary_indicator_var)
        return sum(m.step[leg - 1, :, place].binary_indicator_var) == leaves

    def straight(m: Any, leg: int) -> Any:
        indicators = m.step[leg, :, :].binary_indicator_var
        distance = sum(d * one for d, one in zip(away[leg], indicators, strict=True))
        return m.z[leg, "alpha"] + m.z[leg, "gamma"] + m.w[leg] >= distance

    m.goes_on = Constraint(places, rule=goes_on)
    m.once = Constraint(
        {end for _, end in steps[0]},
        rule=lambda m, place: sum(m.step[:, :, place].binary_indicator_var) == 1,
    )
    m.straight = Constraint(legs, rule=straight)


def _add_quadrants(m: Any, ranges: Ranges) -> None:
    """Tie angles to their sines and cosines.

    This adds to m variables, constraints and one disjunct for each quadrant of an angle.
    """
    from pyomo.environ import Constraint, Var, cos, sin
    from pyomo.gdp import Disjunct, Disjunction

    angles = list(ranges)
    m.q = Var(angles, bounds=(0, _QUARTER), initialize=1)
    m.cos_q = Var(angles, bounds=(0, 1), initialize=math.cos(1))
    m.sin_q = Var(angles, bounds=(0, 1), initialize=math.sin(1))
    m.cosine = Constraint(angles, rule=lambda m, *key: m.cos_q[key] == cos(m.q[key]))
    m.sine = Constraint(angles, rule=lambda m, *key: m.sin_q[key] == sin(m.q[key]))
    quadrants_of = {
        key: range(round(low / _QUARTER), round(high / _QUARTER))
        for key, (low, high) in ranges.items()
    }
    places = [(*key, k) for key, quadrants in quadrants_of.items() for k in quadrants]
    m.quadrant = Disjunct(places, rule=_quadrant)
    m.one_quadrant = Disjunction(
        angles, rule=lambda m, *key: [m.quadrant[(*key, k)] for k in quadrants_of[key]]
    )


def _quadrant(disjunct: Any, leg: int, name: str, k: int) -> None:
    """Add the constraints of quadrant k to a disjunct.

    The disjunct is that of one angle of one leg. Turning by pi / 2 takes (cos, sin) to (-sin, cos).
    """
    from pyomo.environ import Constraint

    m = disjunct.model()
    key = (leg, name)
    c = m.cos_q[key]
    s = m.sin_q[key]
    for _ in range(k % 4):
        c, s = -s, c
    disjunct.angle = Constraint(expr=m.z[key] == m.q[key] + k * _QUARTER)
    disjunct.cosine = Constraint(expr=m.c[key] == c)
    disjunct.sine = Constraint(expr=m.s[key] == s)


def _word(disjunct: Any, leg: int, word: str, steps: dict[tuple[int, int], FloatArray]) -> None:
    """Add a word's constraints to a disjunct.

    The leg goes over its only step, or over the one of several that `_add_steps` lets the engine
    choose. Seen along mu and to its left, that step divided by `scale` is (along, across); it is
    equal to (ahead + sin alpha + sin gamma, aside) / scale. The equations:
    docs/formulations/disjunction.md.
    """
    from pyomo.environ import Constraint

    m = disjunct.model()
    alpha = m.z[leg, "alpha"]
    gamma = m.z[leg, "gamma"]
    cos_a = m.c[leg, "alpha"]
    sin_a = m.s[leg, "alpha"]
    cos_c = m.c[leg, "gamma"]
    sin_c = m.s[leg, "gamma"]
    first = TURN[word[0]]
    last = TURN[word[-1]]
    w = m.w[leg]
    turned = first * alpha
    if leg:  # the direction that the leg is seen along
        mu = m.z[leg, "mu"]
        cos_mu = m.c[leg, "mu"]
        sin_mu = m.s[leg, "mu"]
        disjunct.begins = Constraint(expr=mu == m.theta[leg] + turned - _whole_turns(m, leg))
    else:  # from heading 0
        mu = turned
        cos_mu = cos_a
        sin_mu = first * sin_a
    if len(steps) > 1:
        scale = m.along[leg].ub
        along = m.along[leg] / scale
        across = m.across[leg] / scale
        if not leg:
            disjunct.sees = Constraint(expr=m.first_sine == sin_mu)
    else:
        [step] = steps.values()
        X, Y = step.tolist()
        scale = max(1.0, math.hypot(X, Y))
        along = (X * cos_mu + Y * sin_mu) / scale
        across = (Y * cos_mu - X * sin_mu) / scale
    ahead = w  # of every word but those of three arcs
    aside = last * (1 - cos_c) - first * (1 - cos_a)
    if len(word) == 2:
        unused = w
        if word[1] == "S":
            unused = gamma
        disjunct.absent = Constraint(expr=unused == 0)
    elif "S" in word:
        disjunct.forward = Constraint(expr=alpha >= 0)
        disjunct.and_last = Constraint(expr=gamma >= 0)
        if (leg, "beta") in m.z:  # beta is not used: it is held at one end of its range
            disjunct.absent = Constraint(expr=m.z[leg, "beta"] == _QUARTER)
    else:
        beta = m.z[leg, "beta"]
        ahead = 4 * m.s[leg, "beta"]
        aside = first * (cos_a - cos_c)
        disjunct.middle = Constraint(expr=w == 4 * beta)
        disjunct.forward = Constraint(expr=alpha + beta >= 0)
        disjunct.and_last = Constraint(expr=gamma + beta >= 0)
    disjunct.along = Constraint(expr=along == (ahead + sin_a + sin_c) / scale)
    disjunct.across = Constraint(expr=across == aside / scale)
    if leg + 1 in m.theta:
        disjunct.ends = Constraint(expr=m.theta[leg + 1] == mu + last * gamma)


def _whole_turns(m: Any, point: int) -> Any:
    digits = sum(digit * m.whole[point, digit] for digit in _TURN_DIGITS)
    return TWO_PI * (_FEWEST_TURNS + digits)


def pieces(word: str, alpha: float, gamma: float, w: float, beta: float) -> FloatArray:
    """Lengths (radii) of a word's pieces.

    Shape (2,) for a word of two letters, (3,) for one of three.
    """
    if len(word) == 2:
        last = gamma
        if word[1] == "S":
            last = w
        return np.array((alpha, last))
    if "S" in word:
        return np.array((alpha, w, gamma))
    return np.array((alpha + beta, 2 * beta, gamma + beta))


def transformed(model: Any, transformation: str = "bigm") -> Any:
    """Transform the model into a mixed-integer nonlinear program.

    The model is changed in place and returned.
    """
    from pyomo.environ import TransformationFactory

    TransformationFactory(f"gdp.{transformation}").apply_to(model)
    return model


class Translated(NamedTuple):
    """A program and the places of Pyomo's variables.

    `place` maps the `id` of a variable of the model to its place in the program.
    """

    program: MixedProgram
    place: dict[int, int]


def translated(model: Any) -> Translated:
    """Translate a Pyomo model into a program.

    The model has equations, inequalities and one objective to minimise. Fixed variables stay
    variables, with bounds that meet.
    """
    from pyomo.core.expr.visitor import identify_variables
    from pyomo.environ import Constraint, Objective

    constraints = list(model.component_data_objects(Constraint, active=True, descend_into=True))
    (objective,) = model.component_data_objects(Objective, active=True, descend_into=True)
    variables: dict[int, Any] = {}
    for expression in (*(constraint.expr for constraint in constraints), objective.expr):
        for variable in identify_variables(expression):
            variables.setdefault(id(variable), variable)
    place = {key: n for n, key in enumerate(variables)}
    bounds = []
    for variable in variables.values():
        if variable.fixed:
            bounds.append((variable.value, variable.value))
        else:
            bounds.append(_limits(variable.lb, variable.ub))

    def write(x: Sequence[Any], interface: Any) -> Written:
        functions = Functions(interface)

        def expression(node: Any) -> Any:
            return rebuilt(node, lambda variable: x[place[id(variable)]], functions)

        rows = [Row(expression(c.body), *_limits(c.lb, c.ub)) for c in constraints]
        return Written(expression(objective.expr), rows)

    lower, upper = np.array(bounds, dtype=np.float64).T
    binary = np.array([v.is_binary() for v in variables.values()])
    return Translated(MixedProgram(lower, upper, binary, write), place)


def _limits(lower: float | None, upper: float | None) -> tuple[float, float]:
    """Pyomo's bounds as numbers; None becomes infinite."""
    if lower is None:
        lower = -math.inf
    if upper is None:
        upper = math.inf
    return lower, upper


def rebuilt(node: Any, variable: Callable[[Any], Any], functions: Functions) -> Any:
    """A Pyomo expression, rebuilt in another interface.

    `variable` takes one of Pyomo's variables and returns its counterpart. `functions` has the
    interface's `sin`, `cos` and others.
    """
    if isinstance(node, (int, float)):
        return node
    if node.is_variable_type():
        return variable(node)
    if not node.is_expression_type():
        return node.value
    operands = [rebuilt(child, variable, functions) for child in node.args]
    if type(node).__name__ != "UnaryFunctionExpression":
        # Pyomo's sums, products and powers are Python's operators
        return node._apply_operation(operands)
    return getattr(functions, node.name)(*operands)
