"""Scenarios in which a wrong answer is likely, and answers that are wrong or of unusual shape.

The scenarios lie at every edge of the problem, at every scale. A generator draws the target as a
user computes it, from the start and the heading in doubles, so that it lies beside an edge by what
that arithmetic rounds. Some are then moved by a number of ulp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from flint import arb, ctx

from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import LARGEST_EXTENT, Scenario, ScenarioError
from dubins_study.study.words import BRANCHES
from tests.adversary.oracle import drive

Draw = Callable[[np.random.Generator], Scenario]
S = Scenario
_ROUND = (0.0, math.pi / 2, math.pi, -math.pi / 2, -math.pi)
_LARGEST_HEADING = 150  # power of ten

# reproductions of what an earlier campaign found, which has to stay right
FIXED = (
    S(1e4, 2e4, 1.0, 9998.317058030385, 20001.080604611736, 1),
    S(0, 0, -1.5707963267948966, 1.9999999999999996, 1.2246467991473532e-16, 1),
    S(0, 0, 0, 2.877115121030117e-06, 45.60778211196118, 22.80389105598058),
    S(
        292933.162296969,
        -183188.23419347886,
        -3.2378215871170593,
        292932.8581381104,
        -183188.7936594308,
        0.3459425262285938,
    ),
    S(
        -16935347.04161746,
        32948693.033956386,
        0,
        -16935347.0432896,
        32948693.031933352,
        0.0017030445404372149,
    ),
    S(0, 0, 0.5, -1e150, 1e149, 1e150),
    *(S(0, 0, 0, 5e-324, y, 1) for y in (4, -4, 2, -2, 0, 1, -1)),
    *(S(0, 0, h, x, y, 1) for h in (0, 1, 1e150) for x, y in ((0, 0), (0, 4), (3, 0), (-3, 0))),
    *(S(0, 0, 0, x, y, 1) for x in (-1e-7, 1e-7, 1e-200) for y in (1e-16, -1e-12, 1e-201)),
)


def placed(
    rng: np.random.Generator,
    X: float,
    Y: float,
    *,
    box: float = 5.0,
    heading: float | None = None,
    radius: float = 1.0,
    ulps: bool = False,
) -> Scenario:
    """A scenario whose target is computed in doubles from (X, Y) in the vehicle's frame (radii).

    Args:
        box: half the side of the square in which the start lies, in radii.
        ulps: whether the target is moved by up to 1000 ulp in each coordinate.
    """
    if heading is None:
        heading = float(rng.choice(_ROUND) if rng.random() < 0.15 else rng.uniform(-7, 7))
    x, y = (rng.uniform(-box, box, 2) * radius).tolist()
    cos, sin = math.cos(heading), math.sin(heading)
    target_x = x + radius * (X * cos - Y * sin)
    target_y = y + radius * (X * sin + Y * cos)
    if ulps:
        target_x, target_y = _moved(rng, target_x), _moved(rng, target_y)
    return S(x, y, heading, target_x, target_y, radius)


def _moved(rng: np.random.Generator, value: float) -> float:
    steps = int(rng.choice((-1, 1)) * 10 ** rng.uniform(-0.5, 3))
    return value + steps * math.ulp(value)


def _power(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10 ** rng.uniform(low, high))


def _circle(rng: np.random.Generator, radius: int = 1) -> tuple[float, float]:
    """A point on a circle about one of the turning centres, anywhere on its circumference."""
    a = rng.uniform(-math.pi, math.pi) * _power(rng, -8, 0) ** (rng.random() < 0.2)
    if rng.random() < 0.5:
        a = math.pi - a
    y = float(rng.choice((-1, 1))) * (1 - radius * math.cos(a))
    return radius * math.sin(a), y


def general(rng: np.random.Generator) -> Scenario:
    """A target at any distance and bearing; any radius that a vehicle may have."""
    r, a = _power(rng, -3, 6), rng.uniform(-math.pi, math.pi)
    radius = _power(rng, -6, 6)
    return placed(rng, r * math.cos(a), r * math.sin(a), radius=radius, box=_power(rng, -2, 4))


def near(rng: np.random.Generator) -> Scenario:
    """A target in and about the discs."""
    return placed(rng, *rng.uniform(-4, 4, 2).tolist(), radius=_power(rng, -3, 3))


def circle(rng: np.random.Generator) -> Scenario:
    """A target computed to lie on a turning circle, moved by 0 to 1000 ulp."""
    box = float(rng.choice((0, 1, 10, 1e2, 1e3, 1e4, 1e5)))
    return placed(rng, *_circle(rng), box=box, ulps=rng.random() < 0.7)


def circle_offset(rng: np.random.Generator) -> Scenario:
    """A target on a turning circle, far from the origin of the coordinates."""
    radius = _power(rng, -3, 3)
    return placed(rng, *_circle(rng), box=_power(rng, 5, 12), radius=radius, ulps=True)


def circle_wide(rng: np.random.Generator) -> Scenario:
    """A target beside a turning circle, by any distance from rounding to a tenth of the radius."""
    X, Y = _circle(rng)
    off = 1 + rng.choice((-1, 1)) * _power(rng, -16, -1)
    centre = math.copysign(1.0, Y)
    return placed(rng, X * off, centre + (Y - centre) * off, box=_power(rng, -2, 5))


def reach(rng: np.random.Generator) -> Scenario:
    """A target on the edge of reach of LR or RL: 3 radii from a turning centre, or 1."""
    X, Y = _circle(rng, 3 if rng.random() < 0.7 else 1)
    return placed(rng, X, Y, box=_power(rng, -1, 9), ulps=rng.random() < 0.5)


def tops(rng: np.random.Generator) -> Scenario:
    """(0, 2R), (0, 4R) and their mirror images, where edges meet."""
    y = float(rng.choice((2, -2, 4, -4)))
    x = 0.0 if rng.random() < 0.6 else float(rng.choice((-1, 1))) * _power(rng, -17, -6)
    return placed(rng, x, y, box=_power(rng, -1, 10), ulps=rng.random() < 0.5)


def axis(rng: np.random.Generator) -> Scenario:
    """Straight ahead and straight behind."""
    X = float(rng.choice((-1, 1))) * _power(rng, -9, 9)
    return placed(rng, X, 0.0, box=_power(rng, -2, 8), ulps=rng.random() < 0.5)


def start(rng: np.random.Generator) -> Scenario:
    """The start itself, and targets next to it, by ulp or by any power of ten."""
    if rng.random() < 0.4:
        return placed(rng, 0.0, 0.0, box=_power(rng, -3, 9), ulps=True)
    sizes = 10 ** rng.uniform(-18, -1, 2) if rng.random() < 0.7 else 10 ** rng.uniform(-300, -1, 2)
    X, Y = (sizes * rng.choice((-1, 0, 1, 1), 2)).tolist()
    box = 0.0 if rng.random() < 0.7 else _power(rng, -18, 0)
    return placed(rng, X, Y, box=box)


def denormal(rng: np.random.Generator) -> Scenario:
    """A coordinate of a few 5e-324 beside one of a round number."""
    tiny = float(5e-324 * int(rng.integers(-3, 4)))
    other = float(rng.choice((0, 1, -1, 2, -2, 3, 4, -4, 5e-324, 0.5)))
    x, y = (tiny, other) if rng.random() < 0.5 else (other, tiny)
    return S(0, 0, float(rng.choice(_ROUND)) * float(rng.random() < 0.3), x, y, 1)


def heading(rng: np.random.Generator) -> Scenario:
    """Headings of any size: targets near, and on the circles as doubles compute them."""
    turned = float(rng.choice((-1, 1))) * _power(rng, 0, _LARGEST_HEADING)
    X, Y = _circle(rng) if rng.random() < 0.5 else rng.uniform(-4, 4, 2).tolist()
    return placed(rng, X, Y, box=_power(rng, -1, 3), heading=turned)


def radius(rng: np.random.Generator) -> Scenario:
    """Radii from 1e-150 to 1e150, every edge at that scale."""
    some = (general, near, circle, circle_wide, reach, tops, axis, start)
    shape = some[int(rng.integers(len(some)))](rng)
    size = _power(rng, -150, 150)
    scale = size / shape.radius
    lengths = (shape.x, shape.y, shape.target_x, shape.target_y)
    x, y, target_x, target_y = (value * scale for value in lengths)
    return S(x, y, shape.heading, target_x, target_y, size)


def extent(rng: np.random.Generator) -> Scenario:
    """Coordinates up to the largest that a scenario may have beside its radius."""
    box = LARGEST_EXTENT * _power(rng, -2, 0) / 5
    kind = rng.random()
    if kind < 0.4:
        X, Y = (rng.uniform(-1, 1, 2) * box).tolist()
    else:
        X, Y = _circle(rng) if kind < 0.7 else rng.uniform(-4, 4, 2).tolist()
    return placed(rng, X, Y, box=box)


def grid(rng: np.random.Generator) -> Scenario:
    """Round numbers, which lie on edges exactly."""
    X, Y = rng.choice((0, 0.5, 1, 2, 3, 4, -0.5, -1, -2, -3, -4), 2).tolist()
    x, y = rng.choice((0, 0, 1, -3, 100), 2).tolist()
    size = float(rng.choice((1, 1, 2, 0.1, 25)))
    angle = float(rng.choice((*_ROUND, math.pi / 3, math.pi / 4)))
    return S(x, y, angle, x + X * size, y + Y * size, size)


# each with its share of the cases
SHARES: dict[Draw, int] = {
    general: 10,
    near: 10,
    circle: 15,
    circle_offset: 10,
    circle_wide: 10,
    reach: 8,
    tops: 8,
    axis: 6,
    start: 6,
    denormal: 1,
    heading: 6,
    radius: 5,
    extent: 3,
    grid: 2,
}
_KINDS = [kind for kind, share in SHARES.items() for _ in range(share)]


def case(seed: int, number: int) -> tuple[str, Scenario]:
    """The generator and the scenario of one case, the same for every division into blocks."""
    if number < len(FIXED):
        return "fixed", FIXED[number]
    rng = np.random.default_rng((seed, number))
    kind = _KINDS[number % len(_KINDS)]
    while True:
        try:
            return kind.__name__, kind(rng)
        except ScenarioError:  # outside of what a scenario may hold: another one
            continue


_BITS = 320


class Answer(NamedTuple):
    """A path that is put before the check, and its question."""

    scenario: Scenario
    branch: str
    path: Path


Alter = Callable[[np.random.Generator, Scenario, Path], Answer]


def _branch(rng: np.random.Generator) -> str:
    return str(rng.choice(BRANCHES)) if rng.random() < 0.4 else "best"


def _with_end_as_target(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """The question whose target is the path's own end, rounded to doubles."""
    with ctx.workprec(_BITS):
        controls = zip(path.curvature.tolist(), path.length.tolist(), strict=True)
        moved = drive([(arb(k), arb(s)) for k, s in controls])[0]
        sin, cos = arb(scenario.heading).sin_cos()
        x = float(arb(scenario.x) + moved.real * cos - moved.imag * sin)
        y = float(arb(scenario.y) + moved.real * sin + moved.imag * cos)
    return Answer(replace(scenario, target_x=x, target_y=y), _branch(rng), path)


def other_word(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """The shortest path of one branch as the answer to another."""
    other = shortest_path(scenario, str(rng.choice(BRANCHES)))
    return Answer(scenario, _branch(rng), path if other is None else other)


def full_turn(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """A full turn too much."""
    k = float(rng.choice((-1, 1))) / scenario.radius
    turn = 2 * math.pi * scenario.radius
    return Answer(
        scenario, _branch(rng), Path(scenario.start, [k, *path.curvature], [turn, *path.length])
    )


def altered_length(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """One length changed by any share: the path misses by more than the tolerance, or by less."""
    lengths = path.length.copy()
    if lengths.size:
        lengths[rng.integers(lengths.size)] *= 1 + rng.choice((-1, 1)) * 10 ** rng.uniform(-14, 0)
    return Answer(scenario, _branch(rng), Path(scenario.start, path.curvature, lengths))


def altered_curvature(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """One curvature changed by any share; the target is the new end, or stays."""
    curvature = path.curvature.copy()
    if curvature.size:
        share = 1 + rng.choice((-1, 1)) * 10 ** rng.uniform(-14, -1)
        curvature[rng.integers(curvature.size)] *= share
    changed = Path(scenario.start, curvature, path.length)
    if rng.random() < 0.5:
        return Answer(scenario, _branch(rng), changed)
    return _with_end_as_target(rng, scenario, changed)


def cut_up(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """The right path cut into many pieces, which is as right."""
    n = int(rng.integers(2, 12))
    curvature, length = np.repeat(path.curvature, n), np.repeat(path.length / n, n)
    return Answer(scenario, "best", Path(scenario.start, curvature, length))


def tiny_pieces(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """Arcs with straights between them that are short beside the whole path, then a long way."""
    R = scenario.radius
    n, long = int(rng.integers(1, 100)), 10 ** rng.uniform(0, 7)
    straight = long * 10 ** rng.uniform(-9, -5) * rng.choice((0.1, 0.99, 1))
    curvature = np.tile([1.0, 0.0], n).tolist()
    length = np.tile([3.14 / n, straight], n).tolist()
    if rng.random() < 0.3:
        # turns too small to count, to both sides
        curvature += [1.0, -1.0] * 5
        length += [10 ** rng.uniform(-9, -5)] * 10
    k, s = np.array([*curvature, 0.0]) / R, np.array([*length, long]) * R
    return _with_end_as_target(rng, scenario, Path(scenario.start, k, s))


def random_pieces(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """One to six pieces at full rate or less, the target at their end."""
    n = int(rng.integers(1, 7))
    u = rng.choice((-1.0, 0.0, 1.0), n) if rng.random() < 0.7 else rng.uniform(-1, 1, n)
    s = rng.uniform(0, 4, n) if rng.random() < 0.5 else 10 ** rng.uniform(-8, 1, n)
    R = scenario.radius
    return _with_end_as_target(rng, scenario, Path(scenario.start, u / R, s * R))


def two_pieces(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """Two pieces at full rate, the target at their end: right for short arcs, wrong beyond."""
    first = float(rng.choice((-1, 1)))
    last = float(rng.choice((0.0, -first)))
    R = scenario.radius
    s = rng.uniform(0, 2 * math.pi, 2) * R
    return _with_end_as_target(rng, scenario, Path(scenario.start, np.array([first, last]) / R, s))


def broken(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """A path that nothing can drive: a negative length, or a number that is not finite."""
    curvature, length = [*path.curvature, 1 / scenario.radius], [*path.length, scenario.radius]
    place = int(rng.integers(len(length)))
    bad = float(rng.choice((-4.59, math.nan, math.inf, -1e-12)))
    if bad < 0 or rng.random() < 0.5:
        length[place] = bad * scenario.radius
    else:
        curvature[place] = bad
    short = slice(-2, None)  # two pieces, so that the frame takes it too
    return Answer(scenario, _branch(rng), Path(scenario.start, curvature[short], length[short]))


KINDS: tuple[Alter, ...] = (
    other_word,
    full_turn,
    altered_length,
    altered_curvature,
    cut_up,
    tiny_pieces,
    random_pieces,
    two_pieces,
    broken,
)


def wrong_answer(rng: np.random.Generator, scenario: Scenario) -> tuple[str, Answer]:
    """One altered answer; its kind by name."""
    kind = KINDS[int(rng.integers(len(KINDS)))]
    path = shortest_path(scenario)
    assert path is not None, "some path to every target exists"
    return kind.__name__, kind(rng, scenario, path)
