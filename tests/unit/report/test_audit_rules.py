"""How a printed cell gets its verdict, on rows made up for each accident."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import pytest
from flint import arb

from dubins_study.report.paper.audit_rules import BIAS, CORRECT, CUT, DOUBLE, WRONG, judge
from dubins_study.report.paper.exact import (
    UndecidedError,
    ball,
    decide,
    rounded,
    truncated,
)


def numbers(*texts: str) -> list[arb]:
    return [ball(Fraction(text)) for text in texts]


def verdicts(printed: str, exact: str, biased: str | None = None) -> list[str]:
    row = numbers(*exact.split())
    held = row if biased is None else numbers(*biased.split())
    return [finding.verdict for finding in judge(printed.split(), row, held)]


@pytest.mark.parametrize(
    ("printed", "exact", "verdict"),
    [
        ("1.73", "1.7349", CORRECT),
        ("1.74", "1.735001", CORRECT),
        ("1.74", "1.7349", DOUBLE),  # 1.735, 1.74
        ("1.74", "1.73496", DOUBLE),
        ("1.74", "1.7344", WRONG),  # 1.734, 1.73: no place to round at first gives 1.74
        ("3.38", "3.373651", WRONG),
        ("1.73", "1.7399", CUT),
        ("1.73", "1.735001", CUT),
        ("1.72", "1.734", WRONG),
        ("-1.73", "-1.739", CUT),
    ],
)
def test_the_accident_behind_a_cell(printed, exact, verdict):
    assert verdicts(f"0 0 {printed} {printed}", f"0 0 {exact} {exact}")[2] == verdict


def test_the_bias_is_looked_for_rounded_and_cut_off():
    exact, printed = "2 0 5.4849 7.4849", "2.00 0 {} 7.48"
    assert verdicts(printed.format("5.47"), exact, "2.001 0.001 5.4721 7.4849")[2] == BIAS
    assert verdicts(printed.format("5.47"), exact, "2.001 0.001 5.4789 7.4849")[2] == BIAS
    assert verdicts(printed.format("5.47"), exact, "2.001 0.001 5.4689 7.4849")[2] == BIAS
    assert verdicts(printed.format("5.47"), exact, "2.001 0.001 5.4640 7.4849")[2] == WRONG


def test_of_two_accidents_the_one_that_gives_more_of_the_row_is_named():
    """5.47 is both cut off from 5.479 and what the bias gives: the rest of the row decides."""
    exact, biased = "2.0082 0 5.4790 7.4872", "2.0092 0.001 5.4732 7.4872"

    assert verdicts("2.01 0 5.47 7.49", exact, biased) == [CORRECT, CORRECT, BIAS, CORRECT]
    assert verdicts("2.00 0 5.47 7.48", exact, biased) == [CUT, CORRECT, CUT, CUT]


def test_a_reason_tells_what_the_accident_does_not_give():
    """The printed 0 of the missing turn is held against a bias that would print 0.01."""
    found = judge(
        ("2.01", "0", "5.47", "7.49"),
        numbers("2.0082", "0", "5.4851", "7.4933"),
        numbers("2.0092", "0.006", "5.4730", "7.4882"),
    )[2]

    assert found.verdict == BIAS
    assert "z2 = 0.01 (printed 0)" in found.reason
    assert "z1" not in found.reason


def test_what_the_bounds_do_not_decide_is_not_decided():
    low, high = numbers("1.7349", "1.7351")
    wide = low.union(high)

    assert decide(wide, lambda value: truncated(value, 2)) == Decimal("1.73")
    with pytest.raises(UndecidedError, match=r"1\.73 or 1\.74"):
        decide(wide, lambda value: rounded(value, 2))
