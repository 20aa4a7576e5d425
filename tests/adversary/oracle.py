"""The truth about a question in 60 digits, by geometry: circles, tangents and points, no formula
of the package.

Numbers are balls (Arb), so that every digit that is compared is known to be right. Points are
complex numbers in the vehicle's frame, in radii: the start is 0, it looks along 1, and the turning
circles stand around i and -i. The angle of an arc is the argument of a quotient of two points seen
from its centre. Every path is driven to its end and has to meet its target there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from flint import acb, arb, ctx

from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

DIGITS = 60
_BITS = 420  # a root of a number next to zero loses half of them
_EPS = arb(math.ulp(1.0))
I = acb(0, 1)  # noqa: E741  the imaginary unit
WORDS = ("LS", "RS", "LR", "RL")
# centre and radius of the circles on which a shortest length jumps, begins or ends
CIRCLES = ((I, 1), (-I, 1), (-I, 3), (I, 3))
_EDGES = {"best": (0, 1), "LS": (0,), "RS": (1,), "RL": (0, 1, 2), "LR": (1, 0, 3)}
Pieces = Sequence[tuple[arb, arb]]  # curvature (1 / radius) and length (radii)


class OracleError(AssertionError):
    """The oracle contradicts itself: nothing that it says of this case counts."""


def side(value: arb) -> int:
    """The sign of a number, 0 if its ball holds zero: 60 digits do not tell it from zero."""
    return 1 if value > 0 else -1 if value < 0 else 0


def square(z: acb) -> arb:
    return z.real * z.real + z.imag * z.imag


def bits(scenario: Scenario) -> int:
    """Bits that leave 60 digits of a target next to the start, and of one next to the axis."""
    with ctx.workprec(64):
        size = math.hypot(*(abs(float(part)) for part in _local(scenario)))
    lost = 1600 if size < 1e-290 else max(0.0, -math.log2(size))
    return _BITS + 2 * int(lost)


def _local(scenario: Scenario) -> tuple[arb, arb]:
    dx = arb(scenario.target_x) - arb(scenario.x)
    dy = arb(scenario.target_y) - arb(scenario.y)
    sin, cos = arb(scenario.heading).sin_cos()
    turned = acb(dx, dy) * acb(cos, -sin) / arb(scenario.radius)
    return turned.real, turned.imag


def turned(quotient: acb) -> arb:
    """The argument of a complex number in [0, 2 pi)."""
    if not quotient.real.mid() > 0:  # away from the jump at the positive axis
        return (-quotient).arg() + arb.pi()
    angle = quotient.arg()
    if angle.contains(0):
        return arb(0)
    return angle + 2 * arb.pi() if angle < 0 else angle


def drive(pieces: Pieces, pose: tuple[acb, acb] = (acb(0), acb(1))) -> tuple[acb, acb]:
    """Position and direction at the end of pieces of constant curvature."""
    z, direction = pose
    for k, s in pieces:
        if k == 0:
            z += direction * s
            continue
        sin, cos = (k * s).sin_cos()
        spin = acb(cos, sin)
        z += direction * (spin - 1) / (I * k)
        direction *= spin
    return z, direction


def _left_straight(target: acb) -> Iterator[Pieces]:
    """The tangent from the target to the left circle, met in the direction of driving."""
    d = target - I
    power = square(d) - 1
    if side(power) < 0:
        return
    straight = power.sqrt() if side(power) else arb(0)
    contact = acb(1, -straight) * d / square(d)  # seen from the centre
    yield (arb(1), turned(contact / -I)), (arb(0), straight)


def _right_left(target: acb) -> Iterator[Pieces]:
    """The second centre: where a circle of 2 about -i cuts the circle of 1 about the target."""
    d = target + I
    dd = square(d)
    if side(dd - 1) < 0 or side(9 - dd) < 0:
        return
    along = (dd + 3) / (2 * dd)
    across = 4 / dd - along * along
    off = across.sqrt() if side(across) > 0 else arb(0)
    for root in (off, -off):
        switch = d * acb(along, root) / 2  # seen from -i; the second centre is twice as far
        second = target + I - 2 * switch  # the target seen from the second centre
        yield (arb(-1), turned(I / switch)), (arb(1), turned(second / -switch))


_FIND = {
    "LS": (_left_straight, False),
    "RS": (_left_straight, True),
    "RL": (_right_left, False),
    "LR": (_right_left, True),
}


def paths(target: acb, word: str, driven: bool = False) -> list[Pieces]:
    """All paths of a word with arcs below a full turn; if `driven`, each to its end."""
    find, mirror = _FIND[word]
    found = []
    for pieces in find(target.conjugate() if mirror else target):
        pieces = [(-k, s) if mirror else (k, s) for k, s in pieces]
        if driven:
            off = drive(pieces)[0] - target
            if not abs(off).abs_upper() <= abs(target).mid() * arb(10) ** (5 - DIGITS):
                raise OracleError(f"the {word} path ends {off} from its target {target}")
        found.append(pieces)
    return found


def lengths(target: acb, driven: bool = False) -> dict[str, arb | None]:
    """The shortest length of each word and of all (`best`), in radii; None where there is none."""
    each: dict[str, arb | None] = {}
    for word in WORDS:
        totals = [first[1] + last[1] for first, last in paths(target, word, driven)]
        each[word] = min(totals, key=lambda total: total.mid(), default=None)
    existing = [length for length in each.values() if length is not None]
    each["best"] = min(existing, key=lambda length: length.mid())
    return each


class Member(NamedTuple):
    """A target of the set, its lengths, and which side of every edge it lies on."""

    target: acb
    lengths: dict[str, arb | None]
    label: tuple[int, ...]


class Truth:
    """What is true of a scenario: at its exact target and over the set of its targets.

    Every method has to be called within `ctx.workprec(bits(scenario))`. Lengths are in radii.
    """

    def __init__(self, target: acb, delta: arb) -> None:
        self.target, self.delta = target, delta
        self.exact = lengths(target, driven=True)
        self._members: list[Member] | None = None

    @classmethod
    def of(cls, scenario: Scenario) -> Truth:
        """The exact target, and the set around it: what the data leave open, and a rotation."""
        X, Y = _local(scenario)
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
        """Whether the set, made `stretch` times as wide, meets an edge of the branch."""
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
        """A sample of the set: the target first, then corners and all points next to edges."""
        if self._members is None:
            wanted = [self.target, *self._corners(), *self._edge_points()]
            self._members = [self.member(point) for point in wanted if self.has(point)]
        return self._members

    def refine(self, rng: np.random.Generator, n: int = 150) -> None:
        """Add n random targets of the set, and n on each circle that it meets."""
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
        """On every circle and axis that the set meets, and just off it on both sides."""
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
        """The point of a circle in the direction of a target, and both sides of it."""
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
        """Lengths between which the sampled targets of one side of all edges lie."""
        sides: dict[tuple[int, ...], list[arb]] = {}
        for _, each, label in self.members:
            if (length := each[branch]) is not None:
                sides.setdefault(label, []).append(length)
        return [(least(some), greatest(some)) for some in sides.values()]

    def absent(self, branch: str) -> bool:
        """Whether a sampled target has no path."""
        return any(each[branch] is None for _, each, _ in self.members)


def least(values: Iterable[arb]) -> arb:
    return min(values, key=lambda value: value.mid())


def greatest(values: Iterable[arb]) -> arb:
    return max(values, key=lambda value: value.mid())


def end(scenario: Scenario, path: Path) -> acb:
    """The end of a path's controls, driven in 60 digits, in the vehicle's frame (radii)."""
    radius = arb(scenario.radius)
    controls = zip(path.curvature.tolist(), path.length.tolist(), strict=True)
    return drive([(arb(k) * radius, arb(s) / radius) for k, s in controls])[0]
