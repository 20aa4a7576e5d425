"""The whole test suite that a plug-in needs.

It has every check of the kit, a test each.
"""

import pytest
from honest_dubins import TwoArcs

from dubins_study.conformance import CHECKS, check_solver


@pytest.fixture(scope="module")
def report():
    return check_solver(TwoArcs)


@pytest.mark.parametrize("check", CHECKS)
def test_conformance(report, check):
    assert report[check].passed, report


def test_it_is_the_shortest_everywhere(report):
    """It finds every shortest path.

    That is more than the kit asks: the path of every question that has one.
    """
    assert report.with_status("note") == (), report
