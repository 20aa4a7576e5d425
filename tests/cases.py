"""Scenarios that many tests share.

Hypothesis strategies draw more.
"""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import strategies as st

from dubins_study.solvers.registry import load
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import margin_local
from dubins_study.study.rows.schema import SCENARIO, names
from dubins_study.study.scenario import COLUMNS, NUMBERS, Scenario
from dubins_study.study.words import FROZEN

Triple = tuple[Any, Any, Any]
PAPER = {
    "problem 1": Scenario(0, 0, 2 * math.pi / 3, 10, 5, 1),
    "problem 2": Scenario(0, 0, 2 * math.pi / 3, -6, 3, 1),
    "problem 3": Scenario(0, 0, math.pi / 3, -1, 5, 1),
    "problem 4": Scenario(0, 0, math.pi / 3, -2, -5, 1),
    "problem 5, R=25": Scenario(0, 0, 2 * math.pi / 3, -80, 20, 25),
    "problem 5, R=10": Scenario(0, 0, 2 * math.pi / 3, -80, 20, 10),
    "problem 5, R=5": Scenario(0, 0, 2 * math.pi / 3, -80, 20, 5),
}

# whose label names a frozen convex problem
FROZEN_ROUTE = Scenario(via=[(2, 0), (14, 0)], target_x=14, target_y=2.5, label="qp-50-survey-3-3")

# one engine of each kind, or way of calling it: what a run without `--slow` asks of all of them
QUICK_ENGINES = (
    *("ipopt", "slsqp", "uno-filtersqp", "nlopt-slsqp"),
    *("scip", "differential-evolution", "powell", "hybr", "piqp"),
)


def margin(scenario: Scenario) -> float:
    """Distance from target to nearer turning circle (radii)."""
    target = local(scenario)
    return margin_local(target.X, abs(target.Y))


def engine_params(names: Iterable[str], quick: Iterable[str] = QUICK_ENGINES) -> list[Any]:
    """Names as test parameters; others than quick are slow."""
    chosen = frozenset(quick)
    return [pytest.param(name, marks=() if name in chosen else pytest.mark.slow) for name in names]


def question_for(name: str, scenario: Scenario) -> tuple[Scenario, str, str]:
    """Arguments of `solve` for the best path.

    A solver that answers no paths gets a frozen problem.
    """
    if load(name).branches == (FROZEN,):
        return FROZEN_ROUTE, name, FROZEN
    return scenario, name, "best"


# one of every kind of target there is, none within 0.05 R of a turning circle's front half
EDGES = {
    "ahead": Scenario(0, 0, 0, 5, 0, 1),
    "behind": Scenario(0, 0, 0, -5, 0, 1),
    "just behind": Scenario(0, 0, 0, -0.1, 0, 1),
    "at the start": Scenario(3, -2, 1, 3, -2, 1),
    "centre of the left disc": Scenario(0, 0, 0, 0, 1, 1),
    "centre of the right disc": Scenario(0, 0, 0, 0, -1, 1),
    "off centre in the left disc": Scenario(0, 0, 0, 0.3, 1.2, 1),
    "rear of the right disc": Scenario(0, 0, 0, -0.5, -1.2, 1),
    "beside": Scenario(0, 0, 0, 0, 2.5, 1),
    "far": Scenario(0, 0, 0.4, 700, -300, 1),
    "tiny radius": Scenario(1, 2, 3, 1 + 4e-6, 2 - 3e-6, 1e-6),
    "huge radius": Scenario(-1e6, 2e6, -2, 3e6, 4e6, 1e6),
    "many turns of heading": Scenario(0, 0, f"{40 * math.pi + 0.3}rad", -3, 2, 1),
}


@st.composite
def scenarios(draw: st.DrawFn, far: float = 30.0) -> Scenario:
    """Any pose and radius, and a target nearby.

    The target is up to `far` radii away; in half of the draws it is within 2.5 radii.
    """
    number = st.floats(-100, 100)
    radius = 10 ** draw(st.floats(-3, 3))
    x, y, heading = draw(number), draw(number), draw(st.floats(-10, 10))
    distance = draw(st.one_of(st.floats(0.01, 2.5), st.floats(0.01, far))) * radius
    bearing = draw(st.floats(-math.pi, math.pi))
    return Scenario(
        x * radius,
        y * radius,
        heading,
        x * radius + distance * math.cos(heading + bearing),
        y * radius + distance * math.sin(heading + bearing),
        radius,
    )


def placed(
    X: float,
    Y: float,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
    radius: float = 1.0,
    speed: float = 1.0,
) -> Scenario:
    """A target at (X, Y) of the vehicle's frame.

    X and Y are in radii. The target is computed in doubles as a user does.
    """
    c, s = math.cos(heading), math.sin(heading)
    target = x + radius * (X * c - Y * s), y + radius * (X * s + Y * c)
    return Scenario(x, y, heading, *target, radius, speed)


def scenario_row(scenario: Scenario) -> dict[str, Any]:
    """Columns of a row that describe its scenario."""
    return {name: getattr(scenario, name) for name in names(SCENARIO)}


def scenario_frame(scenarios: Iterable[Scenario]) -> pd.DataFrame:
    """One row per scenario, with the columns `COLUMNS`."""
    rows = list(scenarios)
    columns = {name: [getattr(row, name) for row in rows] for name in COLUMNS}
    return pd.DataFrame(columns).astype(dict.fromkeys(NUMBERS, float))


def walked(length: FloatArray, direction: FloatArray) -> FloatArray:
    """Points of a walk from the origin.

    Each is a step of this length and direction (rad) from the last.
    """
    steps = length[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    return np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])


def driven(pose: Triple, turn: Any, length: Any) -> Triple:
    """The pose at the end of an arc.

    A pose is (x, y, heading). The curvature `turn` may be 0. Arrays are allowed.
    """
    x, y, heading = pose
    middle = heading + turn * length / 2
    chord = length * np.sinc(turn * length / (2 * math.pi))
    return x + chord * np.cos(middle), y + chord * np.sin(middle), heading + turn * length
