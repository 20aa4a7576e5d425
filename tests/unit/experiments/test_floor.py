"""The floor of an engine's times.

It is the quickest of several calls, none of them the first.
"""

from dataclasses import dataclass

import pytest

from dubins_study.experiments.isolation import floor
from dubins_study.experiments.isolation.floor import floor_s
from dubins_study.solvers.one_leg.model import equations
from dubins_study.solvers.paper_nlp.nlp import PaperNlp
from dubins_study.solvers.registry import load
from dubins_study.solvers.runs import no_point
from dubins_study.study.words import Claim


class Clock:
    """Stands still but for what calls take."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def timed(monkeypatch, durations):
    """Floor of an engine with these call times.

    The residual of each guess comes with it.
    """
    clock = Clock()
    calls = []
    monkeypatch.setattr(floor, "perf_counter", clock)

    @dataclass(frozen=True)
    class Slow(PaperNlp):
        def adapter(self):
            def solve(case, guess, seconds):
                clock.now_s += durations[len(calls)]
                calls.append(equations(guess, case.target.X, case.target.Y))
                return no_point(3, Claim.FAILED, "", "")

            return solve

    return floor_s(Slow()), calls


def test_the_least_of_the_later_calls_counts(monkeypatch):
    """The least of the later calls counts.

    The first one loads and compiles, and may as well be quicker by chance.
    """
    measured, calls = timed(monkeypatch, [0.01, 0.04, 0.02, 0.03, 0.05, 0.06, 0.07])
    assert measured == pytest.approx(0.02)
    assert len(calls) == 7


def test_a_slow_engine_is_not_called_often(monkeypatch):
    """A slow engine is not called often.

    Half a second is enough; a second, at which a call is cut off, is no floor.
    """
    measured, calls = timed(monkeypatch, [0.1, 0.6])
    assert (measured, len(calls)) == (pytest.approx(0.6), 2)
    assert timed(monkeypatch, [0.1, 1.2])[0] is None


def test_the_problem_is_solved_where_it_begins(monkeypatch):
    """The problem is solved where it begins.

    Nothing is left to find: the guess meets the target.
    """
    for residual in timed(monkeypatch, [0.1] * 7)[1]:
        assert residual == pytest.approx([0.0, 0.0], abs=1e-15)


def test_an_engine_that_fails_has_no_floor(monkeypatch):
    """A broken library must not end the run."""
    monkeypatch.setattr(PaperNlp, "adapter", lambda self: 1 / 0)
    assert floor_s(PaperNlp()) is None


@pytest.mark.parametrize(
    "spec",
    [
        *("slsqp", "multiple-shooting[engine=uno]", "shooting[root=lm]", "global-nlp"),
        *("heading-milp", "penalty[engine=direct]", "turn-rate-qp[engine=osqp]", "headings"),
    ],
)
def test_every_kind_of_engine_has_a_trivial_problem(spec):
    """Whatever the formulation, its engine is called."""
    measured = floor_s(load(spec))
    assert measured is not None
    assert measured > 0


def test_a_formula_has_no_floor():
    """There is no engine to call."""
    assert floor_s(load("analytic")) is None
