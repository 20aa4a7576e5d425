"""A finding: a sentence to act on, with its number, its interval and what was asked."""

from __future__ import annotations

from typing import NamedTuple

from dubins_study.report.elements.formats import Format, digits, share
from dubins_study.report.elements.identity import with_interval

# Fewer questions than this carry no finding: a bootstrap of so few scenarios is no guide.
ENOUGH = 10

_THREE = digits(3)
POINTS, TIMES, PERCENT = "percentage points", "times", "%"


class Estimate(NamedTuple):
    """A number, the ends of its 95 % interval, and how many questions it is of."""

    value: float
    low: float
    high: float
    questions: int

    def excludes(self, value: float) -> bool:
        """Whether the interval lies on one side of a value."""
        return self.low > value or self.high < value

    def text(self, show: Format = _THREE) -> str:
        """The number and its interval: `2.5 (2.1 to 3.4)`."""
        return with_interval(show, self.value, self.low, self.high)

    def percent_text(self) -> str:
        """A number in per cent and its interval: `25.0 % (21.0 % to 34.2 %)`."""
        return with_interval(share, self.value / 100, self.low / 100, self.high / 100)

    def negated(self) -> Estimate:
        """The estimate of the number with the other sign."""
        return Estimate(-self.value, -self.high, -self.low, self.questions)

    def inverse(self) -> Estimate:
        """The estimate of one over the number, which is above 0."""
        return Estimate(1 / self.value, 1 / self.high, 1 / self.low, self.questions)


class Finding(NamedTuple):
    """A sentence that a practitioner can act on.

    Args:
        sentence: with the number and its interval in it.
        estimate: the number, its interval and the number of questions.
        unit: of the number.
        question: what was asked, of how many questions and methods.
        shown_in: the section, and the table or figure, that shows it.
    """

    sentence: str
    estimate: Estimate
    unit: str
    question: str
    shown_in: str


def percent(estimate: Estimate) -> Estimate:
    """An estimate of a share as one in per cent."""
    value, low, high, questions = estimate
    return Estimate(100 * value, 100 * low, 100 * high, questions)
