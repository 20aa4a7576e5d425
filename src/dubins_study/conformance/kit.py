"""Check a solver: load it, put all questions to it, and say what was found."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from inspect import getsourcefile
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

from dubins_study.conformance import loading
from dubins_study.conformance.checks import CHECKS, failed, run_check, title_of, unfinished
from dubins_study.conformance.findings import CheckResult, Status
from dubins_study.conformance.interview import Interview, UnfinishedError
from dubins_study.conformance.report import ConformanceReport
from dubins_study.conformance.worker import InProcess, LoadError, Source, Worker
from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.attempt import check_request
from dubins_study.solvers.profiles import tolerances
from dubins_study.solvers.protocol import Solver
from dubins_study.solvers.registry import registered_name
from dubins_study.study.values import did_you_mean, short

# Seconds for one question, and for all of them.
TIME_LIMIT_S, TOTAL_TIME_LIMIT_S = 5.0, 600.0


class ConformanceError(DubinsStudyError, ValueError):
    """A request for checks that cannot be met."""


def check_solver(
    solver: str | type[Solver],
    *,
    checks: Iterable[str] = CHECKS,
    time_limit: float = TIME_LIMIT_S,
    total_time_limit: float = TOTAL_TIME_LIMIT_S,
    profile: str = "default",
    isolated: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> ConformanceReport:
    """Check that a solver keeps the promise of `Solver`.

    Args:
        solver: a spec, e.g. `my_solver.py:Mine`, `mine[n=20]` or `slsqp`; or a class, which has to
            be at the top of its file.
        checks: some of `CHECKS`; `loading` is always made.
        time_limit: seconds for each question.
        total_time_limit: seconds for all of them; checks that are not reached by then are
            `not asked`, and the report has not passed.
        profile: `default`, `fast` or `accurate`: the solver's settings and the tolerances.
        isolated: whether the solver is asked in a worker process, where a crash and a hang are
            findings. With False it is asked in this process, as a debugger needs it.
        progress: called with the number of checks done and of all checks.

    Raises:
        SolverError: if there is no such solver, or no class that extends `Solver`.
        ConformanceError, ProfileError, QuestionError: if the request is not a valid one.
        ForkServerError: if no worker process can be started.
    """
    spec = solver if isinstance(solver, str) else _spec_of(solver)
    names = _names(checks)
    check_request("best", time_limit, "time_limit")
    check_request("best", total_time_limit, "total_time_limit")
    tolerances(profile)
    began = monotonic()
    try:
        source: Source = (Worker if isolated else InProcess)(_absolute(spec), profile)
    except LoadError as error:
        found = loading.broken(str(error), error.frames, spec)
        not_asked = [_not_asked(name, "it does not load") for name in names[1:]]
        results = (failed("loading", found), *not_asked)
        return ConformanceReport(spec, results, {}, monotonic() - began)
    checked: list[CheckResult] = []
    with Interview(spec, source, profile, time_limit, total_time_limit) as interview:
        for result in _results(interview, names):
            checked.append(result)
            if progress is not None:
                progress(len(checked), len(names))
    return ConformanceReport(spec, tuple(checked), interview.counts(), monotonic() - began)


def _results(interview: Interview, names: list[str]) -> Iterator[CheckResult]:
    """The results of checks, one after another; of those that are not reached, why."""
    yield loading.check(interview.declared, title_of("loading"), interview.spec)
    reason = interview.declared["unavailable"]
    stopped = "" if reason is None else f"it cannot run here: {reason}"
    for name in names[1:]:
        if stopped:
            yield _not_asked(name, stopped)
            continue
        before = len(interview.seen)
        try:
            yield run_check(interview, name)
        except UnfinishedError as error:
            stopped = str(error)
            yield unfinished(name, interview.seen[before:], stopped)
        if interview.seen and not interview.answered:
            stopped = "no question was answered so far; mend that first"


def _not_asked(name: str, reason: str) -> CheckResult:
    return CheckResult(name, title_of(name), (), reason, Status.NOT_ASKED)


def _names(checks: Iterable[str]) -> list[str]:
    """The checks in their order, `loading` first."""
    asked = [checks] if isinstance(checks, str) else list(checks)
    for name in asked:
        if name not in CHECKS:
            hint = did_you_mean(name, CHECKS)
            raise ConformanceError(
                f"no check named {short(name)}; {hint}choose from: {', '.join(CHECKS)}"
            )
    return [name for name in CHECKS if name in asked or name == "loading"]


def _absolute(spec: str) -> str:
    """The spec with an absolute path, since the worker has a folder of its own."""
    file, mark, rest = spec.partition(".py:")
    return f"{FilePath(file + '.py').absolute()}:{rest}" if mark else spec


def _spec_of(kind: Any) -> str:
    """The spec of a class: its registered name, or its file."""
    if not (isinstance(kind, type) and issubclass(kind, Solver)):
        raise ConformanceError(
            f"solver is {kind!r:.80}; expected a spec, or a class that extends Solver"
        )
    name = registered_name(kind)
    if name is not None:
        return name
    file, title = getsourcefile(kind), kind.__name__
    if file is None or getattr(sys.modules[kind.__module__], title, None) is not kind:
        raise ConformanceError(
            f"solver is the class {title}, which is not at the top of a file; "
            "expected one that `file.py:Class` names"
        )
    return f"{file}:{title}"
