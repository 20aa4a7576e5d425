"""The truth about a question in 60 digits.

It is found by geometry: circles, tangents and points, and no formula of the package.

Numbers are balls (Arb), so that every digit that is compared is known to be right. Points are
complex numbers in the vehicle's frame, in radii: the start is 0, it looks along 1, and the turning
circles stand around i and -i. The angle of an arc is the argument of a quotient of two points seen
from its centre. Every path is driven to its end and has to meet its target there.
"""

import math
from collections.abc import Iterable, Iterator, Sequence

from flint import acb, arb, ctx

from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

DIGITS = 60
_BITS = 420  # a root of a number next to zero loses half of them
I = acb(0, 1)  # noqa: E741  the imaginary unit
WORDS = ("LS", "RS", "LR", "RL")
Pieces = Sequence[tuple[arb, arb]]  # curvature (1 / radius) and length (radii)


class OracleError(AssertionError):
    """The oracle contradicts itself.

    Nothing that it says of this case counts.
    """


def side(value: arb) -> int:
    """Sign of a number; 0 if undecided.

    It is 0 if the ball holds zero: 60 digits do not tell it from zero.
    """
    return 1 if value > 0 else -1 if value < 0 else 0


def square(z: acb) -> arb:
    return z.real * z.real + z.imag * z.imag


def bits(scenario: Scenario) -> int:
    """Bits for 60 digits of a target.

    They suffice next to the start, and next to the axis.
    """
    with ctx.workprec(64):
        size = math.hypot(*(abs(float(part)) for part in local(scenario)))
    lost = 1600 if size < 1e-290 else max(0.0, -math.log2(size))
    return _BITS + 2 * int(lost)


def local(scenario: Scenario) -> tuple[arb, arb]:
    dx = arb(scenario.target_x) - arb(scenario.x)
    dy = arb(scenario.target_y) - arb(scenario.y)
    sin, cos = arb(scenario.heading).sin_cos()
    turned = acb(dx, dy) * acb(cos, -sin) / arb(scenario.radius)
    return turned.real, turned.imag


def turned(quotient: acb) -> arb:
    """Argument of a complex number in [0, 2 pi)."""
    if not quotient.real.mid() > 0:  # away from the jump at the positive axis
        return (-quotient).arg() + arb.pi()
    angle = quotient.arg()
    if angle.contains(0):
        return arb(0)
    return angle + 2 * arb.pi() if angle < 0 else angle


def drive(pieces: Pieces, pose: tuple[acb, acb] = (acb(0), acb(1))) -> tuple[acb, acb]:
    """Position and direction at the end of some pieces.

    Each piece has a constant curvature.
    """
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
    """The tangent from the target to the left circle.

    It is met in the direction of driving.
    """
    d = target - I
    power = square(d) - 1
    if side(power) < 0:
        return
    straight = power.sqrt() if side(power) else arb(0)
    contact = acb(1, -straight) * d / square(d)  # seen from the centre
    yield (arb(1), turned(contact / -I)), (arb(0), straight)


def _right_left(target: acb) -> Iterator[Pieces]:
    """Paths of the word RL.

    The second centre lies where a circle of 2 about -i cuts the circle of 1 about the target.
    """
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
    """All paths of a word; arcs below a turn.

    If `driven`, each is driven to its end.
    """
    find, mirror = _FIND[word]
    results: list[Pieces] = []
    point = target.conjugate() if mirror else target
    for pieces in find(point):
        pieces = [(-k, s) if mirror else (k, s) for k, s in pieces]
        if driven:
            off = drive(pieces)[0] - target
            if not abs(off).abs_upper() <= abs(target).mid() * arb(10) ** (5 - DIGITS):
                raise OracleError(f"the {word} path ends {off} from its target {target}")
        results.append(pieces)
    return results


def lengths(target: acb, driven: bool = False) -> dict[str, arb | None]:
    """Shortest length of each word and of all (`best`).

    In radii; None where there is no path.
    """
    each: dict[str, arb | None] = {}
    for word in WORDS:
        totals = [first[1] + last[1] for first, last in paths(target, word, driven)]
        each[word] = min(totals, key=lambda total: total.mid(), default=None)
    existing = [length for length in each.values() if length is not None]
    each["best"] = min(existing, key=lambda length: length.mid())
    return each


def least(values: Iterable[arb]) -> arb:
    return min(values, key=lambda value: value.mid())


def greatest(values: Iterable[arb]) -> arb:
    return max(values, key=lambda value: value.mid())


def end_of(scenario: Scenario, path: Path) -> acb:
    """End of a path's controls, driven in 60 digits.

    In the vehicle's frame (radii).
    """
    radius = arb(scenario.radius)
    controls = zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
    return drive([(arb(k) * radius, arb(s) / radius) for k, s in controls])[0]
