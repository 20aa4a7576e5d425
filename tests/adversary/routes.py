"""Attack the certified search with shorter small routes.

No small route may be shorter than its proven bound. Each is attacked by other means: by dynamic
programs over 10 000 headings a turn, and downhill from 300 starts.
"""

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.route.search import Route, search
from tests.adversary.leg_lengths import downhill, length_table
from tests.adversary.table import Table
from tests.cases import driven, walked

Array = NDArray[np.float64]
Rng = np.random.Generator

# headings a turn, and how many of them in each window
_FINE = 10_000
_EACH = 20
# windows at a point
_BEST = 15
_RANDOM = 5
# how many go downhill, and how many of them to the end
_STARTS = 300
_FINISHED = 8
_WHOLE = 200  # one route in so many is tried on the whole grid, without windows
_BOXES = 30_000  # of the search, whose bound has to hold whenever it ends: a quarter of a second
# the least lengths that were found for 2 000 routes of seed 0
LENGTHS = np.loadtxt(Path(__file__).with_name("route_lengths.txt"))
TOLERANCE = 1e-12  # relative; what the attack's own rounding and that of the points may take
# How far off a turning circle a point may be by rounding, in radii; the search takes it to be there
_OFF_CIRCLE = 1e-15


class Asked(NamedTuple):
    """A route in radii.

    Points have shape (n + 1, 2). The headings are those at both ends; None is free.
    """

    points: Array
    first: float
    last: float | None


def _spaced(least: float, most: float, rng: Rng, n: int) -> tuple[Array, float]:
    """Legs of random directions; lengths by a law."""
    length = rng.uniform(least, most, n)
    return walked(length, rng.uniform(-math.pi, math.pi, n)), rng.uniform(-math.pi, math.pi)


def _in_line(rng: Rng, n: int) -> tuple[Array, float]:
    """Points on one line.

    The line is driven along, across, or there and back.
    """
    angle = rng.choice([0.0, math.pi / 2, rng.uniform(-math.pi, math.pi)])
    back = rng.choice([0.0, math.pi], n) if rng.random() < 0.6 else np.zeros(n)
    first = angle + rng.choice([0.0, math.pi, math.pi / 2, rng.uniform(-math.pi, math.pi)])
    return walked(rng.uniform(0.1, 6.0, n), angle + back), first


def _u_turns(rng: Rng, n: int) -> tuple[Array, float]:
    """Rows of a field: opposite ways beside each other."""
    width = rng.choice([0.1, 0.5, 1.0, 2.0, rng.uniform(0.1, 4.0)])
    length = np.where(np.arange(n) % 2, width, rng.choice([0.5, 1.0, 3.0, rng.uniform(0.1, 6.0)]))
    direction = np.array([0.0, 0.5, 1.0, 0.5, 0.0])[:n] * math.pi
    return walked(length, direction), float(rng.choice([0.0, math.pi / 2, math.pi]))


def _on_a_path(rng: Rng, n: int) -> tuple[Array, float]:
    """Points where a path changes its turn.

    The path has arcs and straights, so the points lie on turning circles.
    """
    turn = rng.choice([-1.0, 0.0, 1.0], n)
    length = np.where(rng.random(n) < 0.3, math.pi / 2, rng.uniform(0.1, 5.0, n))
    first = rng.choice([0.0, rng.uniform(-math.pi, math.pi)])
    poses = [(0.0, 0.0, float(first))]
    for arc in zip(turn, length, strict=True):
        poses.append(driven(poses[-1], *arc))
    return np.array(poses)[:, :2], float(first)


def _round(rng: Rng, n: int) -> tuple[Array, float]:
    """Points with round coordinates; neighbours are apart.

    Such points lie on turning circles exactly.
    """
    while True:
        points = np.vstack([[0.0, 0.0], rng.choice([-2.0, -1.0, 0.0, 0.5, 1.0, 2.0, 3.0], (n, 2))])
        if np.hypot(*np.diff(points, axis=0).T).min() > 0.0:
            return points, float(rng.choice([0.0, 0.5, 1.0, -0.5])) * math.pi


KINDS: dict[str, Callable[[Rng, int], tuple[Array, float]]] = {
    "0.1 to 0.5": partial(_spaced, 0.1, 0.5),
    "0.1 to 1.3": partial(_spaced, 0.1, 1.3),
    "0.5 to 4": partial(_spaced, 0.5, 4.0),
    "2 to 6": partial(_spaced, 2.0, 6.0),
    "in line": _in_line,
    "U-turns": _u_turns,
    "on a path": _on_a_path,
    "round numbers": _round,
}


def route_of_seed(number: int, seeded: int) -> tuple[str, Asked]:
    """Kind and route of a seed, 2-5 legs."""
    rng = np.random.default_rng((seeded, number))
    kind = list(KINDS)[number % len(KINDS)]
    points, first = KINDS[kind](rng, int(rng.integers(2, 6)))
    last = (None, None, first, first + math.pi, rng.uniform(-math.pi, math.pi))[rng.integers(5)]
    if kind == "on a path" or rng.random() < 0.8:
        return kind, Asked(points, first, last)
    beside = rng.normal(size=points.shape) * 10 ** rng.uniform(-15, -2)
    return kind, Asked(points + beside, first, last)


class Chains(NamedTuple):
    """Best chains of a dynamic program over headings.

    It holds the least length through each heading, and the way to and from it.
    """

    through: list[Array]
    before: list[NDArray[np.intp]]
    after: list[NDArray[np.intp]]

    def headings(self, grid: list[Array], point: int, place: int) -> Array:
        """Headings of the best chain through one heading."""
        chain = [place]
        for before in reversed(self.before[:point]):
            chain.insert(0, int(before[chain[0]]))
        for after in self.after[point:]:
            chain.append(int(after[chain[-1]]))
        return np.array([column[k] for column, k in zip(grid, chain, strict=True)])


def program(legs: Array, grid: list[Array]) -> Chains:
    tables = [length_table(*leg, a, b) for leg, (a, b) in zip(legs, pairwise(grid), strict=True)]
    ahead, behind = [np.zeros(grid[0].size)], [np.zeros(grid[-1].size)]
    before, after = [], []
    for table in tables:
        total = ahead[-1][:, None] + table
        before.append(total.argmin(axis=0))
        ahead.append(total.min(axis=0))
    for table in reversed(tables):
        total = table + behind[0]
        after.insert(0, total.argmin(axis=1))
        behind.insert(0, total.min(axis=1))
    return Chains([a + b for a, b in zip(ahead, behind, strict=True)], before, after)


def whole_grid(legs: Array, ends: list[Array | None]) -> float:
    """Least length over all headings of the fine grid.

    It is computed for 250 rows of a table at a time.
    """
    every = np.arange(_FINE) * (2 * math.pi / _FINE) - math.pi
    cost = np.zeros(1)
    grid = [every if end is None else end for end in ends]
    for leg, (a, b) in zip(legs, pairwise(grid), strict=True):
        total = np.full(b.size, math.inf)
        for low in range(0, a.size, 250):
            part = slice(low, low + 250)
            table = cost[part, None] + length_table(*leg, a[part], b)
            total = np.minimum(total, table.min(axis=0))
        cost = total
    return float(cost.min())


def attacked(asked: Asked, rng: Rng) -> float:
    """Least length by the fine grid and downhill.

    The grid has 500 headings at a point. Then come the fine headings of 20 windows: 15 about the
    headings of the shortest chains, and 5 at random. The search goes downhill from the best chain
    through each window, from chains beside the best of all, and from anywhere.
    """
    legs = np.diff(asked.points, axis=0)
    every = np.arange(_FINE) * (2 * math.pi / _FINE) - math.pi
    ends = [np.array([asked.first]), *[None] * (len(legs) - 1)]
    last = None if asked.last is None else np.array([asked.last])
    ends.append(last)
    free = np.array([end is None for end in ends])
    grid = [every[::_EACH] if end is None else end for end in ends]
    coarse = program(legs, grid)
    windows = []
    for end, through in zip(ends, coarse.through, strict=True):
        if end is not None:
            windows.append(end)
            continue
        best = np.argsort(through, kind="stable")[:_BEST]
        chosen = np.union1d(best, rng.integers(through.size, size=_RANDOM))
        near = np.arange(-_EACH // 2, _EACH // 2)
        windows.append(every[(chosen[:, None] * _EACH + near).ravel() % _FINE])
    fine = program(legs, windows)
    starts = [
        fine.headings(windows, point, low + int(through[low : low + _EACH].argmin()))
        for point, through in enumerate(fine.through)
        if free[point]
        for low in range(0, through.size, _EACH)
    ]
    best = fine.headings(windows, 0, 0)
    for place in range(_STARTS - len(starts)):
        off = rng.normal(size=free.size) * 10 ** rng.uniform(-3, 0)
        anywhere = rng.uniform(-math.pi, math.pi, free.size)
        start = best + off if place % 2 else anywhere
        starts.append(np.where(free, start, best))
    lengths = [downhill(legs, start, free, rng, (0.1, 0.03)) for start in starts]
    finished = {round(lengths[k], 6): starts[k] for k in np.argsort(lengths)[::-1]}
    least = min(float(fine.through[0].min()), *lengths)
    for _, start in sorted(finished.items())[:_FINISHED]:
        least = min(least, downhill(legs, start, free, rng, (0.05, 1e-13)))
    return min(least, whole_grid(legs, ends)) if rng.random() < 1 / _WHOLE else least


def tolerated(asked: Asked) -> float:
    """Tolerated excess of a bound over a length.

    It is a share of the length.

    From a given heading points may lie on turning circles one after another up to rounding. Each
    frees the heading there by the root of what it is off; more than two were not needed.
    """
    off = _OFF_CIRCLE
    for points, heading in ((asked.points, asked.first), (asked.points[::-1], asked.last)):
        freed = _OFF_CIRCLE
        for way in [] if heading is None else np.diff(points, axis=0)[:2]:
            left = np.array([-math.sin(heading), math.cos(heading)])
            if min(abs(math.hypot(*(way - turn * left)) - 1.0) for turn in (1.0, -1.0)) > 9 * freed:
                break
            heading = 2.0 * math.atan2(way[1], way[0]) - heading
            freed = math.sqrt(freed)
        off = max(off, freed)
    return off if off > _OFF_CIRCLE else TOLERANCE


def proven(asked: Asked, number: int) -> Route:
    """Proven interval of the search.

    Its tolerance is in turn that of `shortest_route` and a thousandth of it.
    """
    return search(*asked, boxes=_BOXES, tolerance=(1e-9, 1e-12)[number // len(KINDS) % 2])


def attack(table: Table, seed: int, number: int) -> float:
    """Compare one route's bound with the shortest attack.

    Returns the least length of the attacks.
    """
    table.generator, asked = route_of_seed(number, seed)
    low = proven(asked, number).low
    length = attacked(asked, np.random.default_rng((seed, number, 1)))
    table.note(
        "route beaten", (low - length) / low / tolerated(asked), f"route_of_seed({number}, {seed})"
    )
    return length


def run(seed: int, low: int, high: int) -> Table:
    """Attack a seed's routes from `low` below `high`."""
    table = Table()
    for number in range(low, high):
        attack(table, seed, number)
    return table
