"""The length that an answer which misses its target is fairly compared with."""

from __future__ import annotations

import math
from copy import copy

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.shortest import Shortest, margin, shortest
from dubins_study.study.scenario import Scenario

ROUNDED = 8 * EPS  # relative error of two lengths that ought to be equal
# By how much the optimal length may change per shift of the target, at least: it does by 1 where
# the path ends straight, and more near a turning circle, where that changes within the shift.
STEEP = 10.0


def relaxed_reference(
    scenario: Scenario,
    branch: str,
    length: float,
    miss: float,
    end: tuple[float, float],
    optimum: Shortest | None,
) -> float | None:
    """The length that an answer is compared with.

    That is the scenario's shortest length. Only a miss makes a shorter answer possible: such an
    answer is compared with the least shortest length over the targets within its miss. The length
    jumps only across the front half of a turning circle (docs/derivation.md, section 6), so that
    least length is met, up to the miss itself, at the path's end or at the nearest point of the
    circle. An answer that is shorter by no more than its miss explains has not used the jump.
    """
    bare = None if optimum is None else optimum.total * scenario.radius
    if bare is not None and length >= bare * (1.0 - ROUNDED):
        return bare
    at_end = _shortest_length(_moved(scenario, *end), branch)
    if optimum is not None and bare is not None:
        explained = bare - _steepness(optimum) * miss
        if length >= explained:
            jumps = at_end is None or at_end < explained
            return length if jumps or at_end is None else min(bare, at_end)
    lengths = [at_end]
    if margin(scenario) * scenario.radius <= miss:
        lengths.append(_shortest_length(_moved(scenario, *_onto_circle(scenario)), branch))
    return min((value for value in (bare, *lengths) if value is not None), default=None)


def _moved(scenario: Scenario, x: float, y: float) -> Scenario:
    """The scenario with another target, which may be beyond what a scenario may ask for."""
    moved = copy(scenario)
    object.__setattr__(moved, "target_x", x)
    object.__setattr__(moved, "target_y", y)
    return moved


def _steepness(optimum: Shortest) -> float:
    """How much a shortest length changes per shift of its target, with room for a small shift.

    The gradient's norm is 1 for words that end straight and 1 / |cos(a2 / 2)| for RL and LR
    (docs/derivation.md, section 9), which grows without bound toward the rear of a circle.
    """
    if optimum.word not in ("LR", "RL"):
        return STEEP
    return max(STEEP, 2.0 / max(abs(math.cos(optimum.segments.second / 2)), EPS))


def _shortest_length(scenario: Scenario, branch: str) -> float | None:
    optimum = shortest(scenario, branch)
    return None if optimum is None else optimum.total * scenario.radius


def _onto_circle(scenario: Scenario) -> tuple[float, float]:
    """The point of the nearer turning circle that is nearest to the target.

    It lies outside by rounding, never inside: next to the start delta is finer than the rounding of
    this point.
    """
    _, Y = scenario.local()
    side = math.copysign(scenario.radius, Y)
    x = scenario.x - side * math.sin(scenario.heading)
    y = scenario.y + side * math.cos(scenario.heading)
    dx, dy = scenario.target_x - x, scenario.target_y - y
    stretch = scenario.radius * (1.0 + ROUNDED) / math.hypot(dx, dy)
    return x + dx * stretch, y + dy * stretch
