"""One question put to a solver, and its reply."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

from dubins_study.solvers.presolve import presolved
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.registry import unavailable
from dubins_study.study.rows.schema import Times
from dubins_study.study.words import NEEDS, Claim, Outcome

# Long enough for every backend on every question; a solve here lasts microseconds to seconds.
DEFAULT_LIMIT = 60.0
# The share of the limit that a solver does not get; the time for building is taken off too. An
# engine that ends just in time still has to hand over its answer, and an answer after the limit is
# a failure.
_HELD_BACK = 0.05

_NO_TIMES = Times()


class Reply(NamedTuple):
    """The answer to a question before it is judged.

    The fields after `times` are filled in by the worker of a run.
    """

    outcome: Outcome
    solution: Solution
    times: Times = _NO_TIMES
    started: str = ""  # when the solve started (UTC, ISO 8601); empty if it did not start
    versions: str = ""  # of the solver's libraries, as JSON
    code_digest: str = ""  # of the solver's code (see `code_digest`); empty if it did not load
    memory_mib: float | None = None  # added by the solve to the memory of its process
    floor_s: float | None = None  # the engine's time for a trivial problem


def no_answer(outcome: Outcome, message: str, times: Times = _NO_TIMES, status: str = "") -> Reply:
    """The reply of a solver that did not answer.

    `message` says why. The reply has no path and makes no claim.
    """
    return Reply(outcome, Solution(Claim.NONE, native_status=status, message=message), times)


def raised_answer(error: BaseException, times: Times = _NO_TIMES) -> Reply:
    """The reply of a solver that raised an exception."""
    outcome = Outcome.RAISED
    if isinstance(error, MemoryError):
        outcome = Outcome.OUT_OF_MEMORY
    return no_answer(outcome, exception_text(error), times)


def ask(
    solver: Solver,
    question: Question,
    limit: float = DEFAULT_LIMIT,
    raised: Callable[[BaseException], None] | None = None,
) -> Reply:
    """Put a question to a solver and time it.

    A solver that is unavailable, or does not take the question, is not asked; the reply says why.
    If the presolve answers the question, the solver is not asked either. An exception that the
    solver raises becomes its reply; before that, `raised` is called with the exception and its
    traceback. `limit` is in seconds.
    """
    reason = unavailable(solver)
    if reason is not None:
        return no_answer(Outcome.UNAVAILABLE, reason)
    if not_taken := [need for need in question.scenario.needs if need not in solver.takes]:
        takes = ", ".join(need for need in NEEDS if need in solver.takes) or "nothing"
        reason = f"{solver.name} does not take: {', '.join(not_taken)}; it takes: {takes}"
        return no_answer(Outcome.UNSUPPORTED, reason)
    if question.branch not in solver.branches:
        reason = f"{solver.name} answers {', '.join(solver.branches)}, not {question.branch}"
        return no_answer(Outcome.UNSUPPORTED, reason)
    began = perf_counter()
    built = None
    try:
        solution = None
        if solver.presolve is True:
            solution = presolved(question)
        if solution is not None:
            built = perf_counter()
        else:
            model = solver.build(question)
            built = perf_counter()
            # building is taken off the limit, but some time to solve is left always
            limit_left = max((1 - _HELD_BACK) * limit - (built - began), _HELD_BACK * limit)
            solution = solver.solve(model, limit_left)
        ended = perf_counter()
        if not isinstance(solution, Solution):
            raise TypeError(f"solve returned {type(solution).__name__}; expected a Solution")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a backend's exception is its result
        ended = perf_counter()
        if isinstance(error.__cause__, KeyboardInterrupt):  # in a compiled loop: a SystemError
            raise KeyboardInterrupt from None
        if raised is not None:
            raised(error)
        build_s = None
        if built is not None:
            build_s = built - began
        return raised_answer(error, Times(build_s=build_s, wall_s=ended - began))
    times = Times(build_s=built - began, solve_s=ended - built, wall_s=ended - began)
    return Reply(Outcome.RETURNED, solution, times)


_CLOCKS_APART_S = 1e-3  # largest difference between two readings of the machine's clocks


def with_possible_times(reply: Reply, waited_s: float) -> Reply:
    """The reply, unless one of its times is impossible.

    A time is impossible if it is negative or longer than the caller waited. The outcome is then
    `raised`: a library may replace the clock of the process that solves.
    """
    for name, seconds in vars(reply.times).items():
        if seconds is not None and not 0 <= seconds <= waited_s + _CLOCKS_APART_S:
            message = (
                f"ValueError: {name} is {seconds!r}; expected a time from 0 to {waited_s:.3g} s: "
                "the clock was replaced"
            )
            solution = Solution(Claim.NONE, message=message)
            return reply._replace(outcome=Outcome.RAISED, solution=solution, times=_NO_TIMES)
    return reply


_MAX_MESSAGE_CHARS = 2000  # a row holds no longer message


def exception_text(error: BaseException) -> str:
    """An exception's name and message as one text.

    If the exception cannot be converted to text, the result is only its name.
    """
    name = type(error).__name__
    try:
        text = str(error)
    except BaseException:  # whatever a plug-in's exception raises
        return name
    return f"{name}: {text or 'no message'}"[:_MAX_MESSAGE_CHARS]
