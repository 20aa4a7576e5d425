"""`trace=true`: the best headings on the way to an answer, as the check judges them."""

from __future__ import annotations

import numpy as np
import pytest

from dubins_study import Scenario, solve
from dubins_study.experiments.isolation.messages import WorkerReply, decode_reply, encode_reply
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.solvers.reply import ask

ROUTE = Scenario(heading=0.5, target_x=10, target_y=5, via=[(4, 1), (6, -2), (3, 3)])
ENGINES = ("nelder-mead", "differential-evolution", "cma-es", "slsqp", "nlopt-cobyla")


@pytest.mark.parametrize("engine", ENGINES)
def test_a_trace_gets_better_until_the_answer(engine):
    """Evaluations grow, lengths fall, the last is the answer's, and tracing changes no answer."""
    spec = f"headings[engine={engine}]"
    traced, plain = solve(ROUTE, f"{spec[:-1]},trace=true]"), solve(ROUTE, spec)

    assert plain.trace_evaluations is None
    assert plain.length == traced.length
    assert np.all(np.diff(traced.trace_evaluations) > 0)
    assert np.all(np.diff(traced.trace_lengths) < 0)
    assert traced.trace_lengths[-1] == pytest.approx(traced.length, rel=1e-12)
    assert len(traced.trace_lengths) > 3


@pytest.mark.parametrize("engine", ["nelder-mead", "powell"])
def test_a_trace_is_what_smaller_budgets_give(engine):
    """A search that may evaluate no more than N times returns what the trace has at N."""
    traced = solve(ROUTE, f"headings[engine={engine},trace=true]")

    for place in (1, len(traced.trace_lengths) // 2):
        budget = int(traced.trace_evaluations[place])
        short = solve(ROUTE, f"headings[engine={engine},evaluations={budget}]")
        assert short.length == pytest.approx(traced.trace_lengths[place], rel=1e-12)


def test_runs_from_several_guesses_are_counted_one_after_another():
    """What the second run finds has been paid for by all of the first."""
    spec = "headings[engine=nelder-mead,initial_guess=random,seed=1,trace=true,count={}]"
    one, both = (solve(ROUTE, spec.format(count)) for count in (1, 2))

    later = [n for n in both.trace_evaluations if n > one.trace_evaluations[-1]]
    assert both.length < one.length
    assert later
    assert min(later) > one.evaluations


def test_a_trace_travels_with_its_reply():
    """As plain values, path by path."""
    reply = ask(load("headings[engine=nelder-mead,trace=true]"), Question(ROUTE))

    sent = decode_reply(encode_reply(WorkerReply(reply)))

    assert sent.reply.solution.trace == reply.solution.trace
    assert len(reply.solution.trace) > 3
