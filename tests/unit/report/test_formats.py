"""Numbers as text, against texts by hand."""

from __future__ import annotations

import pytest

from dubins_study.report.elements.formats import digits


@pytest.mark.parametrize(
    ("n", "value", "text"),
    [
        (3, 15930.0, "15\u202f930"),
        (3, 999.6, "1\u202f000"),
        (3, -1152, "−1\u202f152"),
        (6, 1152.0, "1152.00"),
        (3, 999, "999"),
        (3, 2e6, "2.00e6"),
        (1, 1e-5, "1e−5"),
        (1, 0.05, "0.05"),
    ],
)
def test_digits(n, value, text):
    """Whole numbers have thin spaces between thousands, as counts have; others are as they were."""
    assert digits(n)(value) == text
