"""Scenarios and answers in which mistakes are likely.

The answers are wrong or of unusual shape. The scenarios lie at every edge of the problem, at every
scale. A generator computes the target as a user does, from the start and the heading in doubles,
so that it lies beside an edge by the rounding of that arithmetic. Some are then moved by a number
of ulp.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from flint import arb, ctx

from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import LARGEST_EXTENT, Scenario, ScenarioError
from dubins_study.study.words import BRANCHES
from tests import cases
from tests.adversary.oracle import drive

Rng = np.random.Generator
S = Scenario
_ROUND = (0.0, math.pi / 2, math.pi, -math.pi / 2, -math.pi)

# reproductions of what an earlier campaign found, which has to stay right
FOUND = {
    "top, far from the origin": S(1e4, 2e4, 1.0, 9998.317058030385, 20001.080604611736, 1),
    "top, heading down": S(0, 0, -math.pi / 2, 1.9999999999999996, 1.2246467991473532e-16, 1),
    "top, ahead by a hair": S(
        *(0, 0, 0, 2.877115121030117e-06, 45.60778211196118, 22.80389105598058)
    ),
    "inside by a hair": S(
        *(292933.162296969, -183188.23419347886, -3.2378215871170593),
        *(292932.8581381104, -183188.7936594308, 0.3459425262285938),
    ),
    "tiny radius far away": S(
        *(-16935347.04161746, 32948693.033956386, 0),
        *(-16935347.0432896, 32948693.031933352, 0.0017030445404372149),
    ),
    "just behind the start, beside the axis and a circle": S(
        *(-631863061.6509018, -1270932786.5693164, -1.0650437884893282),
        *(-631863061.6682206, -1270932786.5380447, 565.3008639090407),
    ),
    "beside (0, 4)": S(0, 0, 0, 5e-324, 4, 1),
    "beside (0, -4)": S(0, 0, 0, 5e-324, -4, 1),
    "next to the start": S(0, 0, 0, 1e-9, 1e-12, 1),
    "just behind the start": S(0, 0, 0, -1e-12, 1e-25, 1),
}
FIXED = (
    *FOUND.values(),
    S(0, 0, 0.5, -1e150, 1e149, 1e150),
    *(S(0, 0, 0, 5e-324, y, 1) for y in (2, -2, 0, 1, -1)),
    *(S(0, 0, h, x, y, 1) for h in (0, 1, 1e150) for x, y in ((0, 0), (0, 4), (3, 0), (-3, 0))),
    *(S(0, 0, 0, x, y, 1) for x in (-1e-7, 1e-7, 1e-200) for y in (1e-16, -1e-12, 1e-201)),
)


def placed(
    rng: Rng,
    X: float,
    Y: float,
    *,
    box: float = 5.0,
    heading: float | None = None,
    radius: float = 1.0,
    ulps: float = 0.0,
) -> Scenario:
    """A scenario with its target given in radii.

    The target is computed in doubles from (X, Y) in the vehicle's frame.

    The start lies in a square of half the side `box` (radii). `ulps` is the share of targets that
    are moved by up to 1000 ulp in each coordinate.
    """
    if heading is None:
        is_round = rng.random() < 0.15
        heading = float(rng.choice(_ROUND)) if is_round else float(rng.uniform(-7, 7))
    x, y = (rng.uniform(-box, box, 2) * radius).tolist()
    scenario = cases.placed(X, Y, x, y, heading, radius)
    if rng.random() < ulps:
        steps = (rng.choice((-1, 1), 2) * 10 ** rng.uniform(-0.5, 3, 2)).astype(int).tolist()
        target = scenario.target_x, scenario.target_y
        moved = (v + n * math.ulp(v) for v, n in zip(target, steps, strict=True))
        scenario = S(x, y, heading, *moved, radius)
    return scenario


def power(rng: Rng, low: float, high: float) -> float:
    return float(10 ** rng.uniform(low, high))


def sign(rng: Rng) -> float:
    return float(rng.choice((-1, 1)))


def on_circle(rng: Rng, radius: int = 1) -> tuple[float, float]:
    """A random point on one of the turning circles."""
    a = rng.uniform(-math.pi, math.pi) * power(rng, -8, 0) ** (rng.random() < 0.2)
    if rng.random() < 0.5:
        a = math.pi - a
    return radius * math.sin(a), sign(rng) * (1 - radius * math.cos(a))


def anywhere(rng: Rng) -> tuple[float, float]:
    """A point in and about the discs."""
    X, Y = rng.uniform(-4, 4, 2).tolist()
    return X, Y


def general(rng: Rng) -> Scenario:
    r = power(rng, -3, 6)
    a = rng.uniform(-math.pi, math.pi)
    at = r * math.cos(a), r * math.sin(a)
    return placed(rng, *at, radius=power(rng, -6, 6), box=power(rng, -2, 4))


def beside_circle(rng: Rng) -> Scenario:
    X, Y = on_circle(rng)
    off = 1 + sign(rng) * power(rng, -16, -1)
    centre = math.copysign(1.0, Y)
    return placed(rng, X * off, centre + (Y - centre) * off, box=power(rng, -2, 5))


def tops(rng: Rng) -> Scenario:
    x = 0.0 if rng.random() < 0.6 else sign(rng) * power(rng, -17, -6)
    return placed(rng, x, float(rng.choice((2, -2, 4, -4))), box=power(rng, -1, 10), ulps=0.5)


def start(rng: Rng) -> Scenario:
    if rng.random() < 0.4:
        return placed(rng, 0.0, 0.0, box=power(rng, -3, 9), ulps=1)
    smallest = -18 if rng.random() < 0.7 else -300
    sizes = 10 ** rng.uniform(smallest, -1, 2)
    X, Y = (sizes * rng.choice((-1, 0, 1, 1), 2)).tolist()
    box = 0.0 if rng.random() < 0.7 else power(rng, -18, 0)
    return placed(rng, X, Y, box=box)


def denormal(rng: Rng) -> Scenario:
    tiny = float(5e-324 * int(rng.integers(-3, 4)))
    other = float(rng.choice((0, 1, -1, 2, -2, 3, 4, -4, 5e-324, 0.5)))
    x, y = (tiny, other) if rng.random() < 0.5 else (other, tiny)
    return S(0, 0, float(rng.choice(_ROUND)) * float(rng.random() < 0.3), x, y, 1)


def any_radius(rng: Rng) -> Scenario:
    names = ("general", "near", "circle", "beside a circle", "reach", "tops", "axis", "start")
    shape = SCENARIOS[str(rng.choice(names))][1](rng)
    size = power(rng, -150, 150)
    scale = size / shape.radius
    lengths = (shape.x, shape.y, shape.target_x, shape.target_y)
    x, y, target_x, target_y = (value * scale for value in lengths)
    return S(x, y, shape.heading, target_x, target_y, size)


def extent(rng: Rng) -> Scenario:
    box = LARGEST_EXTENT * power(rng, -2, 0) / 5
    far = (rng.uniform(-1, 1, 2) * box).tolist()
    at = (far, on_circle(rng), anywhere(rng))[int(rng.integers(3))]
    return placed(rng, *at, box=box)


def grid(rng: Rng) -> Scenario:
    X, Y = rng.choice((0, 0.5, 1, 2, 3, 4, -0.5, -1, -2, -3, -4), 2).tolist()
    x, y = rng.choice((0, 0, 1, -3, 100), 2).tolist()
    size = float(rng.choice((1, 1, 2, 0.1, 25)))
    angle = float(rng.choice((*_ROUND, math.pi / 3, math.pi / 4)))
    return S(x, y, angle, x + X * size, y + Y * size, size)


# each kind with its share of the cases
SCENARIOS: dict[str, tuple[int, Callable[[Rng], Scenario]]] = {
    "general": (10, general),  # any distance and bearing; any radius that a vehicle may have
    "near": (10, lambda r: placed(r, *anywhere(r), radius=power(r, -3, 3))),
    # computed to lie on a turning circle, up to 1e5 and up to 1e12 radii from the origin
    "circle": (15, lambda r: placed(r, *on_circle(r), box=int(power(r, -1, 5)), ulps=0.7)),
    "circle, far off": (
        10,
        lambda r: placed(r, *on_circle(r), box=power(r, 5, 12), radius=power(r, -3, 3), ulps=1),
    ),
    # by any distance from rounding to a tenth of the radius
    "beside a circle": (10, beside_circle),
    # the edge of reach of LR and RL: 3 radii from a turning centre, or 1
    "reach": (
        8,
        lambda r: placed(r, *on_circle(r, int(r.choice((1, 3, 3)))), box=power(r, -1, 9), ulps=0.5),
    ),
    "tops": (8, tops),  # (0, 2R), (0, 4R) and their mirror images, where edges meet
    "axis": (
        6,
        lambda r: placed(r, sign(r) * power(r, -9, 9), 0.0, box=power(r, -2, 8), ulps=0.5),
    ),
    "start": (6, start),  # the start itself, and next to it, by ulp or by any power of ten
    "denormal": (1, denormal),  # a coordinate of a few 5e-324 beside one of a round number
    "heading": (
        6,
        lambda r: placed(
            r,
            *(on_circle(r) if r.random() < 0.5 else anywhere(r)),
            box=power(r, -1, 3),
            heading=sign(r) * power(r, 0, 150),
        ),
    ),
    "radius": (5, any_radius),  # radii from 1e-150 to 1e150, every edge at that scale
    "extent": (3, extent),  # coordinates up to the largest that a scenario may have
    "grid": (2, grid),  # round numbers, which lie on edges exactly
}
_KINDS = [kind for kind, (share, _) in SCENARIOS.items() for _ in range(share)]


def case(seed: int, number: int) -> tuple[str, Scenario]:
    """Kind and scenario of one case.

    They are the same for every division into blocks.
    """
    if number < len(FIXED):
        return "fixed", FIXED[number]
    rng = np.random.default_rng((seed, number))
    kind = _KINDS[number % len(_KINDS)]
    while True:
        try:
            return kind, SCENARIOS[kind][1](rng)
        except ScenarioError:  # outside of what a scenario may hold: another one
            continue


class Answer(NamedTuple):
    """A path that is checked, and its question."""

    scenario: Scenario
    branch: str
    path: Path


Controls = tuple[Sequence[float], Sequence[float]]  # rates (curvature times radius), radii


def _one_altered(rng: Rng, values: Sequence[float], largest: float) -> Sequence[float]:
    """One of the values changed by any share."""
    altered = np.array(values)
    if altered.size:
        altered[rng.integers(altered.size)] *= 1 + sign(rng) * power(rng, -14, largest)
    return altered.tolist()


def _cut_up(rng: Rng, u: Sequence[float], s: Sequence[float]) -> Controls:
    n = int(rng.integers(2, 12))
    return np.repeat(u, n).tolist(), np.repeat(np.array(s) / n, n).tolist()


def _tiny_pieces(rng: Rng, u: Sequence[float], s: Sequence[float]) -> Controls:
    n = int(rng.integers(1, 100))
    long = power(rng, 0, 7)
    straight = long * power(rng, -9, -5) * rng.choice((0.1, 0.99, 1))
    u, s = [1.0, 0.0] * n, [3.14 / n, straight] * n
    if rng.random() < 0.3:  # turns too small to count, to both sides
        u, s = u + [1.0, -1.0] * 5, s + [power(rng, -9, -5)] * 10
    return [*u, 0.0], [*s, long]


def _random_pieces(rng: Rng, u: Sequence[float], s: Sequence[float]) -> Controls:
    n = int(rng.integers(1, 7))
    rates = rng.choice((-1.0, 0.0, 1.0), n) if rng.random() < 0.7 else rng.uniform(-1, 1, n)
    lengths = rng.uniform(0, 4, n) if rng.random() < 0.5 else 10 ** rng.uniform(-8, 1, n)
    return rates.tolist(), lengths.tolist()


def _two_pieces(rng: Rng, u: Sequence[float], s: Sequence[float]) -> Controls:
    first = sign(rng)
    return [first, rng.choice((0.0, -first))], rng.uniform(0, 2 * math.pi, 2).tolist()


def _broken(rng: Rng, u: Sequence[float], s: Sequence[float]) -> Controls:
    # two, so that a frame takes it too
    rates = [*u, 1.0][-2:]
    lengths = [*s, 1.0][-2:]
    bad = float(rng.choice((-4.59, math.nan, math.inf, -1e-12)))
    spoilt = lengths if bad < 0 or rng.random() < 0.5 else rates
    spoilt[int(rng.integers(len(spoilt)))] = bad
    return rates, lengths


Alter = Callable[[Rng, Sequence[float], Sequence[float]], Controls]
# each kind with the share of its answers whose target is the altered path's own end
ALTERED: dict[str, tuple[float, Alter]] = {
    "other word": (0, lambda rng, u, s: (u, s)),  # as the answer to another branch
    "full turn": (0, lambda rng, u, s: ([sign(rng), *u], [2 * math.pi, *s])),
    "altered length": (0, lambda rng, u, s: (u, _one_altered(rng, s, 0))),
    "altered curvature": (0.5, lambda rng, u, s: (_one_altered(rng, u, -1), s)),
    "cut up": (0, _cut_up),  # the right path in many pieces, which is as right
    "tiny pieces": (1, _tiny_pieces),  # arcs with straights between them, then a long way
    "random pieces": (1, _random_pieces),
    "two pieces": (1, _two_pieces),  # right for short arcs, wrong beyond
    "broken": (0, _broken),  # nothing can drive it
}


def _with_end_as_target(scenario: Scenario, path: Path) -> Scenario:
    """The scenario whose target is the path's end.

    The end is rounded to doubles.
    """
    with ctx.workprec(320):
        controls = zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
        moved = drive([(arb(k), arb(s)) for k, s in controls])[0]
        sin, cos = arb(scenario.heading).sin_cos()
        x = float(arb(scenario.x) + moved.real * cos - moved.imag * sin)
        y = float(arb(scenario.y) + moved.real * sin + moved.imag * cos)
    return replace(scenario, target_x=x, target_y=y)


def wrong_answer(rng: Rng, scenario: Scenario) -> tuple[str, Answer]:
    """One altered answer, and its kind.

    It answers the scenario or one of its own.
    """
    while True:
        kind = str(rng.choice(list(ALTERED)))
        moved, alter = ALTERED[kind]
        word = str(rng.choice(BRANCHES)) if kind == "other word" else "best"
        path = shortest_path(scenario, word) or shortest_path(scenario)
        assert path is not None, "some path to every target exists"
        R = scenario.radius
        u, s = alter(rng, (path.curvatures * R).tolist(), (path.lengths / R).tolist())
        path = Path(scenario.start, np.array(u) / R, np.array(s) * R)
        branch = str(rng.choice(BRANCHES)) if rng.random() < 0.4 else "best"
        try:
            asked = _with_end_as_target(scenario, path) if rng.random() < moved else scenario
        except ScenarioError:  # the path ends where no scenario's target may lie
            continue
        return kind, Answer(asked, branch, path)
