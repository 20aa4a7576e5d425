"""The paper's paths in interval arithmetic (Arb, through python-flint), and printed numbers.

Everything is computed in the vehicle's frame at unit radius, as in `study.closed_form.shortest`,
but with proven bounds and with the exact headings of the paper (2 pi/3 is not rounded to a double).
The formulas are not trusted: `report.paper.audit` drives each path and checks that it arrives.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import ROUND_DOWN, ROUND_HALF_UP, Context, Decimal
from fractions import Fraction
from typing import NamedTuple, TypeVar

from flint import arb, fmpq

from dubins_study.report.paper.printed import Problem

T = TypeVar("T")
KEPT = 40  # significant digits


class UndecidedError(ArithmeticError):
    """The two bounds of a number give different answers: it was computed with too few digits."""


def decide(value: arb, rule: Callable[[Decimal], T]) -> T:
    """The result of a monotonic rule for a number, proven by applying it to both of its bounds."""
    low, high = (rule(_decimal(end)) for end in (value.lower(), value.upper()))
    if low != high:
        raise UndecidedError(f"{value.str(20)}: {low} or {high}")
    return low


def _decimal(bound: arb) -> Decimal:
    """A bound, a whole number times a power of two, with all its decimals."""
    mantissa, exponent = map(int, bound.man_exp())
    if exponent >= 0:
        return Decimal(mantissa << exponent)
    return Decimal(f"{mantissa * 5**-exponent}e{exponent}")


def text(value: arb, digits: int = KEPT) -> str:
    """A number correctly rounded to significant digits."""
    return str(decide(value, Context(prec=digits, rounding=ROUND_HALF_UP).plus))


def rounded(value: Decimal, places: int) -> Decimal:
    """Rounded to `places` decimals, half away from zero."""
    return value.quantize(Decimal(1).scaleb(-places), ROUND_HALF_UP)


def truncated(value: Decimal, places: int) -> Decimal:
    """Cut off after `places` decimals."""
    return value.quantize(Decimal(1).scaleb(-places), ROUND_DOWN)


def places_of(printed: str) -> int:
    """Number of decimals of a printed number."""
    return len(printed.partition(".")[2])


def half_unit(places: int) -> Decimal:
    """Half a unit of the last of `places` decimals."""
    return Decimal(5).scaleb(-places - 1)


WORKING = 90  # digits; 40 are kept, and bisection and cancellation cost a few
NIL = Fraction(1, 10**60)  # a number that is zero in theory counts as zero below this
_STEPS = 300  # bisections: each halves the interval, and 90 digits are 299 bits
Pieces = tuple[arb, arb, arb]


def ball(value: Fraction | Decimal | int) -> arb:
    """A rational number as a ball."""
    fraction = Fraction(value)
    return arb(fmpq(fraction.numerator, fraction.denominator))


def positive(value: arb) -> bool:
    """Whether a number lies above zero; `UndecidedError` if its ball holds zero."""
    if value.contains(0):
        raise UndecidedError(f"the sign of {value.str(5)}")
    return bool(value > 0)


class Target(NamedTuple):
    """The target in the vehicle's frame, in units of the radius."""

    X: arb
    Y: arb

    @property
    def mirrored(self) -> Target:
        return Target(self.X, -self.Y)

    @property
    def w(self) -> arb:
        """1 - |T - C_L|^2: positive inside the left turning circle."""
        return self.Y * (2 - self.Y) - self.X**2

    def after_left(self, angle: arb) -> Target:
        """The target in the vehicle's frame after a left turn by an angle (rad)."""
        sin, cos = angle.sin_cos()
        forward, left = self.X - sin, self.Y - (1 - cos)
        return Target(forward * cos + left * sin, left * cos - forward * sin)


def target(problem: Problem, radius: arb | None = None) -> Target:
    """The target in the vehicle's frame, in radii; `radius` replaces the problem's radius."""
    sin, cos = heading(problem).sin_cos()
    x, y = problem.target
    R = ball(problem.radius) if radius is None else radius
    return Target((x * cos + y * sin) / R, (y * cos - x * sin) / R)


def heading(problem: Problem) -> arb:
    return ball(problem.heading) * arb.pi()


def left_straight(at: Target) -> tuple[arb, arb]:
    """LS: angle and straight (docs/derivation.md, eq. 3); none inside the left turning circle."""
    if positive(at.w):
        raise UndecidedError("no LS: the target lies inside the left turning circle")
    s = (-at.w).sqrt()
    half = arb.atan2(at.Y, at.X + s) if positive(at.X) else arb.atan2(s - at.X, at.Y - 2)
    return (2 * half if positive(half) else 2 * half + 2 * arb.pi()), s


def pieces(problem: Problem, word: str) -> Pieces:
    """z1, z2, z3 (length unit) of the paper's LS or RS."""
    at = target(problem)
    unit = left_straight(at if word == "LS" else at.mirrored)
    turn, straight = (value * problem.radius for value in unit)
    return (turn, arb(0), straight) if word == "LS" else (arb(0), turn, straight)


def offset(problem: Problem, z: Pieces) -> tuple[arb, arb]:
    """Left-hand sides of (4.10) and (4.11) at z: target minus the end of the path (length unit)."""
    th0 = heading(problem)
    R = ball(problem.radius)
    th1 = th0 + z[0] / R
    th2 = th1 - z[1] / R
    (s0, c0), (s1, c1), (s2, c2) = (angle.sin_cos() for angle in (th0, th1, th2))
    x, y = problem.target
    return x - R * (-s0 + 2 * s1 - s2) - z[2] * c2, y - R * (c0 - 2 * c1 + c2) - z[2] * s2


def distance(sides: tuple[arb, arb]) -> arb:
    """Length of a vector that is not zero."""
    return (sides[0] ** 2 + sides[1] ** 2).sqrt()


def ipopt_barrier() -> arb:
    """Ipopt's last barrier parameter with default options, 2.506e-9.

    From mu = 0.1 it takes max(tol / 11, min(0.2 mu, mu^1.5)) until the complementarity, mu, is
    below tol = 1e-8 (Waechter and Biegler 2006, eqs. 7 and 8).
    """
    tolerance, mu = ball(Fraction(1, 10**8)), ball(Fraction(1, 10))
    while not mu < tolerance:
        mu = (mu / 5).min(mu ** ball(Fraction(3, 2))).max(tolerance / 11)
    return mu


def biased(problem: Problem, word: str, mu: arb) -> Pieces:
    """z1, z2, z3 where a log barrier of weight mu stops on model (4.12), near the LS or RS.

    z1 parametrises the model's feasible curve. At unit radius, with the target at (X, Y) after the
    first turn, dz2 = 1 - 2 cos z2 + 2 X / z3 and dz3 = -2 X / z3, so df = 2 (1 - cos z2), and
    f - (mu / R) (log z1 + log z2 + log z3) is stationary where `slope` below is zero. Near LS that
    is z2 = (mu R^2)^(1/3) in length units: the segments are off while f holds to mu's order.
    """
    R = ball(problem.radius)
    at, weight = target(problem), mu / R
    turn = sum(pieces(problem, word)[:2]) / R

    def after(z1: arb) -> tuple[arb, arb, arb, arb]:
        there = at.after_left(z1)
        z2, z3 = left_straight(there.mirrored)
        drift = 2 * there.X / z3
        slope = 2 * (1 - z2.cos())
        pull = 1 / z1 + (1 - 2 * z2.cos() + drift) / z2 - drift / z3
        return z1, z2, z3, slope - weight * pull

    # R S begins with the turn; in L S the second turn is what the barrier adds behind the first.
    # At RS the minimum is strict: z1 rises from zero to about mu over the model's slope.
    base, guess = turn, weight ** ball(Fraction(1, 3))
    if word == "RS":
        base, guess = arb(0), weight / (2 * (1 - turn.cos()))
    z1, z2, z3, _ = after(base + _root(lambda t: after(base + t)[3], guess / 4, guess * 4))
    return z1 * R, z2 * R, z3 * R


def _root(function: Callable[[arb], arb], low: arb, high: arb) -> arb:
    """The root of a function that is negative at `low` and positive at `high`, by bisection.

    The bisection ends where the function's ball no longer decides its sign.
    """
    if positive(function(low)) or not positive(function(high)):
        raise ValueError("no change of sign to close in on")
    for _ in range(_STEPS):
        middle = ((low + high) / 2).mid()
        try:
            low, high = (low, middle) if positive(function(middle)) else (middle, high)
        except UndecidedError:
            break
    return low.union(high)
