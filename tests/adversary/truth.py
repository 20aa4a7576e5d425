"""The truth of a scenario: targets and lengths.

It has the exact target, and the set of targets that the data leave open.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple, Self

import numpy as np
from flint import acb, arb

from dubins_study.study.scenario import Scenario
from tests.adversary.oracle import I, greatest, least, lengths, local, side, square

_EPS = arb(math.ulp(1.0))
# centre and radius of the circles on which a shortest length jumps, begins or ends
CIRCLES = ((I, 1), (-I, 1), (-I, 3), (I, 3))
_EDGES = {"best": (0, 1), "LS": (0,), "RS": (1,), "RL": (0, 1, 2), "LR": (1, 0, 3)}


class Member(NamedTuple):
    """A target of the set and its lengths.

    It also says on which side of every edge the target lies.
    """

    target: acb
    lengths: dict[str, arb | None]
    label: tuple[int, ...]


class Truth:
    """The truth at the exact target and around it.

    Every method has to be called within `ctx.workprec(bits(scenario))`. Lengths are in radii.
    """

    def __init__(self, target: acb, delta: arb) -> None:
        self.target = target
        self.delta = delta
        self.exact = lengths(target, driven=True)
        self._members: list[Member] | None = None

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """The exact target and the set around it.

        The set holds what the data leave open, and a rotation.
        """
        X, Y = local(scenario)
        given = scenario.x, scenario.y, scenario.target_x, scenario.target_y
        extent = sum((abs(arb(value)) for value in given), arb(0))
        rounding = 2 * _EPS * extent / arb(scenario.radius)
        return cls(acb(X, Y), rounding + 12 * _EPS * (abs(X) + abs(Y)))

    def has(self, target: acb, stretch: float = 1.0) -> bool:
        """Whether a target belongs to the set."""
        off = target - self.target
        room = self.delta * stretch
        return side(abs(off.real) - room) <= 0 and side(abs(off.imag) - room) <= 0

    def touches(self, branch: str, stretch: float = 1.0) -> bool:
        """Whether the set meets an edge of the branch.

        The set is first made `stretch` times as wide.
        """
        room = self.delta * stretch
        if self.has(acb(0), stretch):
            return True
        low, high = self.target.imag - room, self.target.imag + room
        ahead = side(self.target.real + room) >= 0 and side(low) <= 0 <= side(high)
        if branch in ("LS", "RS") and ahead:
            return True
        return any(self._meets(*CIRCLES[i], room) for i in _EDGES[branch])

    def _meets(self, centre: acb, radius: int, room: arb) -> bool:
        off = self.target - centre
        x, y = abs(off.real), abs(off.imag)
        near = [part - room if side(part - room) > 0 else arb(0) for part in (x, y)]
        least = near[0] ** 2 + near[1] ** 2
        most = (x + room) ** 2 + (y + room) ** 2
        return side(least - radius**2) <= 0 <= side(most - radius**2)

    @property
    def members(self) -> list[Member]:
        """A sample of the set.

        The target comes first, then corners and all points next to edges.
        """
        if self._members is None:
            wanted = [self.target, *self._corners(), *self._edge_points()]
            self._members = [self.member(point) for point in wanted if self.has(point)]
        return self._members

    def refine(self, rng: np.random.Generator, n: int = 150) -> None:
        """Add n random targets of the set.

        Another n are added on each circle that the set meets.
        """
        self.members.extend(map(self.member, filter(self.has, self._random(rng, n))))

    def member(self, target: acb) -> Member:
        edges = [square(target - centre) - radius**2 for centre, radius in CIRCLES]
        label = *map(side, edges), side(target.imag), side(target.real)
        return Member(target, lengths(target), label)

    def _corners(self) -> Iterator[acb]:
        for right in (-1, 0, 1):
            for up in (-1, 0, 1):
                if right or up:
                    yield self.target + acb(right, up) * self.delta

    def _edge_points(self) -> Iterator[acb]:
        """Points of every edge that the set meets.

        They lie on circles and axes, and just off them on both sides.
        """
        hair = self.delta / 2**40
        X, Y = self.target.real, self.target.imag
        for centre, radius in CIRCLES:
            if self._meets(centre, radius, self.delta):
                yield from self._onto(centre, radius, self.target)
                for corner in list(self._corners())[::2]:
                    yield next(self._onto(centre, radius, corner), corner)
        for off in (-hair, arb(0), hair):
            yield acb(X, off)
            yield acb(off, Y)
        if self.has(acb(0)):
            yield acb(0)
            for share in (1e-3, 0.1, 0.9):
                room = self.delta * share - abs(X)
                yield from (acb(x, y) for x in (room, -room) for y in (-hair, arb(0), hair))
        yield from (acb(0, y) for y in (2, -2, 4, -4))

    def _onto(self, centre: acb, radius: int, point: acb) -> Iterator[acb]:
        """Points of a circle towards a target.

        One lies on the circle, the others on both sides of it.
        """
        off = point - centre
        if side(square(off)) > 0:
            unit = off / square(off).sqrt()
            for more in (arb(0), self.delta / 2**40, -self.delta / 2**40):
                yield centre + unit * (radius + more)

    def _random(self, rng: np.random.Generator, n: int) -> Iterator[acb]:
        met = [circle for circle in CIRCLES if self._meets(*circle, self.delta)]
        for right, up in rng.uniform(-1, 1, (n, 2)).tolist():
            point = self.target + acb(right, up) * self.delta
            yield point
            for centre, radius in met:
                yield from self._onto(centre, radius, point)

    def hulls(self, branch: str) -> list[tuple[arb, arb]]:
        """Intervals of the lengths of the sampled targets.

        One interval for each side of all edges.
        """
        sides: dict[tuple[int, ...], list[arb]] = {}
        for _, each, label in self.members:
            if (length := each[branch]) is not None:
                sides.setdefault(label, []).append(length)
        return [(least(some), greatest(some)) for some in sides.values()]

    def absent(self, branch: str) -> bool:
        """Whether a sampled target has no path."""
        return any(each[branch] is None for _, each, _ in self.members)
