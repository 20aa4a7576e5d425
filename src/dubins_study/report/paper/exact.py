"""The paper's paths in interval arithmetic.

Printed numbers are compared with these paths. Arb computes them, through python-flint, in the
vehicle's frame at unit radius, as in `study.closed_form.shortest`. The bounds are proven, and the
headings are exact (2 pi/3 is not rounded to a double). The formulas are not trusted: each path is
driven, and must arrive.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import ROUND_HALF_UP, Decimal
from fractions import Fraction

from flint import acb, arb, fmpq
from scipy.optimize import brentq

from dubins_study.report.paper.printed import Problem

WORKING = 90  # digits; 40 are kept, and cancellation costs a few
_NIL = Fraction(1, 10**60)  # a number that is zero in theory counts as zero below this
_KEPT = 40  # significant digits
Pieces = tuple[arb, arb, arb]


def ball(value: Fraction | Decimal | int) -> arb:
    """A rational number as a ball that contains it."""
    fraction = Fraction(value)
    return arb(fmpq(fraction.numerator, fraction.denominator))


def positive(value: arb) -> bool:
    """Whether a number is above zero, proven.

    An error is raised if its ball contains zero.
    """
    if value.contains(0):
        raise ArithmeticError(f"too few digits for the sign of {value.str(5)}")
    return bool(value > 0)


def text(value: arb) -> str:
    """A number as text with 40 significant digits.

    The last digit is proven up to one unit.
    """
    return str(value.str(_KEPT, radius=False))


def truncated(value: arb, places: int) -> Decimal:
    """A number cut off after `places` decimals, proven.

    The number must not be negative. An error is raised if its ball leaves the digits open.
    """
    whole = (value * 10**places).floor().unique_fmpz()
    if whole is None:
        raise ArithmeticError(f"too few digits to cut {value.str(20)} off after {places} decimals")
    return Decimal(int(whole)).scaleb(-places)


def rounded(value: arb, places: int) -> Decimal:
    """A number rounded to `places` decimals, proven.

    Half is rounded up. The number must not be negative.
    """
    return truncated(value + half_unit(places), places)


def rounded_twice(value: arb, first: int, places: int) -> Decimal:
    """A number rounded to `first` decimals, then `places`."""
    return rounded(value, first).quantize(Decimal(1).scaleb(-places), ROUND_HALF_UP)


def half_unit(places: int) -> arb:
    """Half a unit of the last of `places` decimals."""
    return ball(Fraction(1, 2 * 10**places))


# A point of the plane is the complex number x + iy.


def direction(angle: arb) -> acb:
    """The unit vector at an angle (rad)."""
    return acb(0, angle).exp()


def heading(problem: Problem) -> arb:
    return ball(problem.heading) * arb.pi()


def target(problem: Problem, radius: arb) -> acb:
    """The target in the vehicle's frame at the start.

    The length unit is `radius`. The conjugate of the result is the target of the mirrored problem.
    """
    return acb(*problem.target) * direction(-heading(problem)) / radius


def after_left(at: acb, angle: arb) -> acb:
    """The target as seen after a left turn.

    `at` is the target before the turn; the turn is by `angle` (rad), at unit radius.
    """
    return (at - 1j) * direction(-angle) + 1j


def left_straight(at: acb) -> tuple[arb, arb]:
    """Turn (rad) and straight of LS, at unit radius.

    The target must be outside the left turning circle. Seen from the circle's centre, the target
    lies as far ahead as the straight is long, and 1 to the right; ahead is the direction of
    arrival.
    """
    straight = (abs(at - 1j) ** 2 - 1).sqrt()
    turn = (1 + 1j * at).arg() - straight.atan()
    if not positive(turn):
        turn += 2 * arb.pi()
    return turn, straight


def pieces(problem: Problem, word: str) -> Pieces:
    """z1, z2, z3 of the paper's LS or RS.

    They are balls around the exact values, in the length unit. One of the turns z1 and z2 is 0. An
    assertion checks that the path arrives.
    """
    at = target(problem, arb(problem.radius))
    if word != "LS":
        at = at.conjugate()
    turn, straight = (value * problem.radius for value in left_straight(at))
    z = (turn, arb(0), straight)
    if word != "LS":
        z = (arb(0), turn, straight)
    assert miss(problem, z) < ball(_NIL), f"{problem.label}, {word} does not arrive"
    return z


def miss(problem: Problem, z: Sequence[arb]) -> arb:
    """Distance of the target from a path's end.

    It is the length of the vector (4.10) + i (4.11).
    """
    th0 = heading(problem)
    th1 = th0 + z[0] / problem.radius
    th2 = th1 - z[1] / problem.radius
    turns = 2 * direction(th1) - direction(th0) - direction(th2)
    end = -1j * problem.radius * turns + z[2] * direction(th2)
    return abs(acb(*problem.target) - end)


# Ipopt's last barrier parameter with default options, 2.506e-9: from mu = 0.1 it takes
# min(0.2 mu, mu^1.5), which is 0.02 and then four times mu^1.5, until mu is below tol = 1e-8
# (Waechter and Biegler 2006, eqs. 7 and 8).
IPOPT_BARRIER = 0.02 ** (1.5**4)


def biased(problem: Problem, word: str) -> Pieces:
    """z1, z2, z3 at which Ipopt's barrier stops.

    The model is (4.12). The values lie near those of LS or RS, and have ten digits. z1 parametrises
    the model's feasible curve. At unit radius, with the target at (X, Y) after the first turn, dz2
    = 1 - 2 cos z2 + 2 X / z3 and dz3 = -2 X / z3, so df = 2 (1 - cos z2), and f - (mu / R) (log z1
    + log z2 + log z3) is stationary where `slope` is `weight` times `pull`. Near LS that is z2 =
    (mu R^2)^(1/3) in length units: the segments are off while f holds to mu's order.
    """
    R = problem.radius
    at = target(problem, arb(R))
    weight = IPOPT_BARRIER / R
    # `base` is the first turn of the exact path, 0 for RS. The unknown `first` comes on top of it.
    # R S begins with the turn; in L S the second turn is what the barrier adds behind the first.
    base = pieces(problem, word)[0] / R

    def second(first: float) -> tuple[arb, arb]:
        return left_straight(after_left(at, base + first).conjugate())

    def excess(first: float) -> float:
        """Slope minus weighted pull; zero at the stationary point.

        `first` is how far (rad) the first turn exceeds that of the exact path.
        """
        z2, z3 = second(first)
        drift = 2 * after_left(at, base + first).real / z3
        slope = 2 * (1 - z2.cos())
        pull = 1 / (base + first) + (1 - 2 * z2.cos() + drift) / z2 - drift / z3
        return float(slope - weight * pull)

    first = brentq(excess, 1e-12, 0.1, xtol=1e-24)
    z2, z3 = second(first)
    return (base + first) * R, z2 * R, z3 * R
