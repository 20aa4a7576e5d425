"""Numbers known to lie between two fractions, and the ways to print them."""

from __future__ import annotations

from collections.abc import Callable
from decimal import ROUND_HALF_UP, Context, Decimal
from fractions import Fraction
from typing import NamedTuple, TypeVar

T = TypeVar("T")
KEPT = 40  # significant digits


class UndecidedError(ArithmeticError):
    """The two bounds of a number give different answers: it was computed with too few digits."""


class Number(NamedTuple):
    """A real number in [low, high]."""

    low: Fraction
    high: Fraction

    def decide(self, rule: Callable[[Fraction], T]) -> T:
        """The result of a monotonic rule for the number, proven by applying it to both bounds.

        Raises:
            UndecidedError: if they disagree.
        """
        low, high = rule(self.low), rule(self.high)
        if low != high:
            raise UndecidedError(
                f"between {float(self.low)} and {float(self.high)}: {low} or {high}"
            )
        return low

    def below(self, bound: Fraction) -> bool:
        """Whether its absolute value is proven to lie below a bound."""
        return max(-self.low, self.high) < bound

    def text(self, digits: int = KEPT) -> str:
        """Correctly rounded to significant digits."""
        return str(self.decide(lambda value: _significant(value, digits)))

    def __float__(self) -> float:
        return float((self.low + self.high) / 2)


def rounded(value: Fraction, places: int) -> Decimal:
    """Rounded to `places` decimals, half away from zero."""
    unit = Fraction(1, 10**places)
    steps = int(abs(value) / unit + Fraction(1, 2))  # int() cuts, and the operand is not negative
    return _decimal(steps if value >= 0 else -steps, places)


def truncated(value: Fraction, places: int) -> Decimal:
    """Cut off after `places` decimals."""
    return _decimal(int(value * 10**places), places)


def rounded_twice(value: Fraction, first: int, places: int) -> Decimal:
    """Rounded to `first` decimals, and the result rounded to `places` decimals."""
    return rounded(Fraction(rounded(value, first)), places)


def _decimal(steps: int, places: int) -> Decimal:
    return Decimal(steps).scaleb(-places, Context(prec=200))


def _significant(value: Fraction, digits: int) -> Decimal:
    context = Context(prec=digits, rounding=ROUND_HALF_UP)
    return context.divide(Decimal(value.numerator), Decimal(value.denominator))


def places_of(printed: str) -> int:
    """Number of decimals of a printed number."""
    return len(printed.partition(".")[2])


def half_unit(places: int) -> Fraction:
    """Half a unit of the last of `places` decimals."""
    return Fraction(1, 2 * 10**places)
