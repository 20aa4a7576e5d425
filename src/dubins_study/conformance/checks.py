"""Check a solver, and report the findings.

The solver is loaded, and the questions of each check are put to it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from inspect import getsourcefile
from itertools import chain
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

from dubins_study.asking.attempt import check_request
from dubins_study.conformance import behaviour, questions
from dubins_study.conformance.answers import problems, united
from dubins_study.conformance.behaviour import Checked
from dubins_study.conformance.interview import (
    Interview,
    LoadError,
    NotApplicableError,
    Seen,
    UnfinishedError,
    Worker,
)
from dubins_study.conformance.observer import Observer
from dubins_study.conformance.report import CheckResult, ConformanceReport, Finding, Part, Status
from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import registered_name
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.kinds.table import KINDS, PATHLESS
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.specs import plugin_file
from dubins_study.study.tolerances import tolerances
from dubins_study.study.values import did_you_mean, short
from dubins_study.study.words import Outcome

TOTAL_TIME_LIMIT_S = 600.0  # for all questions
_ALL = (Part.CONTROLS, Part.CLAIM, Part.BOUND, Part.LENGTH)


class ConformanceError(DubinsStudyError, ValueError):
    """A request for checks that cannot be met."""


def _best_paths(
    scenarios: Mapping[str, Scenario],
    parts: tuple[Part, ...] = _ALL,
    pathless: bool = False,
) -> Callable[[Interview], Checked]:
    """A function that checks the best paths of scenarios.

    The function asks about the scenarios that the solver takes, and reports the problems of `parts`
    of the answers. If `pathless`, a solver of a kind without paths is asked for the points of that
    kind.
    """

    def run(interview: Interview) -> Checked:
        branch = "best"
        suitable = interview.taken(scenarios)
        if pathless and not interview.answers(branch):
            for kind in PATHLESS:
                if interview.answers(kind.branches[0]):
                    branch = kind.branches[0]
                    suitable = questions.OF_KIND[kind.name]
        if not interview.answers(branch):
            raise NotApplicableError("the solver does not answer `best`")
        if not suitable:
            raise NotApplicableError(_takes_only(interview))
        answers = [interview.ask(Question(scenario, branch)) for scenario in suitable.values()]
        findings = _wrong(interview, answers, parts)
        without_path = all(seen.answer.path is None for seen in answers)
        if Part.CONTROLS in parts and not findings and without_path:
            raise NotApplicableError("it returned no path")
        return findings, f"{len(suitable)} questions"

    return run


def _takes_only(interview: Interview) -> str:
    """Why a check has no question for a solver."""
    return f"the solver takes only {', '.join(interview.declared['takes'])}"


def _wrong(
    interview: Interview, answers: Iterable[Seen], parts: tuple[Part, ...] = _ALL
) -> list[Finding]:
    """Findings about the given parts of answers.

    Findings about a missing answer have the part `OUTCOME`; `_results` adds them to every check.
    """
    findings = chain.from_iterable(problems(interview, seen) for seen in answers)
    return [finding for finding in findings if finding.kind in parts]


def _branches(interview: Interview) -> Checked:
    """Ask for every word that the solver declares.

    A path of the word exists for some questions, and for others none.
    """
    words = [word for word in questions.WORDS if interview.answers(word)]
    if not words or not interview.taken(questions.GENERAL):
        raise NotApplicableError("the solver declares no word of a leg with a free final heading")
    of_words: list[Question] = []
    for word in words:
        scenarios = (*questions.WORDS[word], questions.WITHOUT[word])
        of_words += [Question(scenario, word) for scenario in scenarios]
    return _wrong(interview, map(interview.ask, of_words)), ", ".join(words)


def _warm(interview: Interview) -> Checked:
    """Ask with initial guesses: helpful, misleading, empty."""
    if not (interview.declared["warm"] and interview.answers("best")):
        raise NotApplicableError("the solver takes no initial guess")
    if not interview.taken(questions.GENERAL):
        raise NotApplicableError(_takes_only(interview))
    scenario = questions.REFERENCE
    radius = scenario.radius
    guesses = {
        "the shortest path of a near target": shortest_path(questions.NEAR),
        "a path to elsewhere": Path(scenario.start, [1 / radius, 0.0, -1 / radius], [radius] * 3),
        "a path of no arcs": Path(scenario.start, [], []),
    }
    guessed = (
        Question(replace(scenario, label=f"initial guess: {name}"), initial_guess=guess)
        for name, guess in guesses.items()
    )
    return _wrong(interview, map(interview.ask, guessed)), f"{len(guesses)} initial guesses"


# name -> title, and the function that makes the check; simple questions first
_CHECKS: dict[str, tuple[str, Callable[[Interview], Checked]]] = {
    "loading": ("loads, and says what it is", behaviour.loading),
    "outcome": (
        "returns a Solution, and neither raises, crashes nor hangs",
        _best_paths(questions.GENERAL, (), pathless=True),
    ),
    "controls": (
        "paths start at the start, keep the radius and arrive",
        _best_paths(questions.GENERAL, (Part.CONTROLS,)),
    ),
    "claims": (
        "claims of optimality, of a lower bound, of no path; paths that are longer",
        _best_paths(questions.GENERAL, (Part.CLAIM, Part.LENGTH, Part.BOUND), pathless=True),
    ),
    "axis": ("targets straight ahead, straight behind, at the start", _best_paths(questions.AXIS)),
    "discs": (
        "targets within a turning disc, where RL or LR is shortest",
        _best_paths(questions.DISCS),
    ),
    "circles": ("targets on and near a turning circle", _best_paths(questions.CIRCLES)),
    "symmetries": ("mirrored, moved and turned questions", _best_paths(questions.SYMMETRIES)),
    "scale": ("one question larger, smaller, farther, faster", _best_paths(questions.SCALES)),
    **{
        f"{kind.name}s": (kind.task, _best_paths(questions.OF_KIND[kind.name]))
        for kind in KINDS
        if kind.task
    },
    "branches": ("the words that it declares", _branches),
    "warm": ("initial guesses, good and bad", _warm),
    "limits": ("returns by its time limit", behaviour.limits),
    "determinism": ("the same question has the same answer", behaviour.determinism),
    "state": ("leaves its process as it was", behaviour.state),
}
CHECKS = tuple(_CHECKS)
TITLES = {name: title for name, (title, _) in _CHECKS.items()}


def check_solver(
    solver: str | type[Solver],
    *,
    checks: Iterable[str] = CHECKS,
    time_limit: float = questions.TIME_LIMIT_S,
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
    spec = _spec_of(solver)
    names = _names(checks)
    check_request("best", time_limit, "time_limit")
    check_request("best", total_time_limit, "total_time_limit")
    tolerances(profile)
    began = monotonic()
    absolute = spec
    if plugin := plugin_file(spec):  # absolute, since the worker has a folder of its own
        absolute = f"{FilePath(plugin.file).absolute()}:{plugin.class_name}"
    source_class: type[Observer | Worker] = Observer
    if isolated:
        source_class = Worker
    try:
        source = source_class(absolute, profile)
    except LoadError as error:
        repeat = questions.check_command(spec, "loading", time_limit, profile)
        finding = behaviour.broken(error, spec, repeat)
        not_asked = [_not_asked(name, "it does not load") for name in names[1:]]
        results = [CheckResult("loading", TITLES["loading"], (finding,)), *not_asked]
        return ConformanceReport(spec, tuple(results), {}, monotonic() - began)
    results = []
    with closing(source):
        interview = Interview(spec, source, profile, limit=time_limit, total_limit=total_time_limit)
        for result in _results(interview, names):
            results.append(result)
            if progress is not None:
                progress(len(results), len(names))
    return ConformanceReport(
        solver=spec,
        results=tuple(results),
        answers=interview.counts(),
        seconds=monotonic() - began,
        worst_gap=interview.worst_gap(),
        claimed=interview.claimed(),
    )


def _results(interview: Interview, names: list[str]) -> Iterator[CheckResult]:
    """Yield the result of each check.

    Findings about missing answers are added to those of the check that asked. The result of a check
    that is not reached tells why.
    """
    stopped = ""
    for name in names:
        title, run = _CHECKS[name]
        if stopped:
            yield _not_asked(name, stopped)
            continue
        before = len(interview.seen)
        applied = Status.PASS
        findings: Iterable[Finding] = ()
        try:
            findings, summary = run(interview)
        except NotApplicableError as reason:
            summary = str(reason)
            applied = Status.NOT_APPLICABLE
        except (UnfinishedError, LoadError) as reason:
            summary = str(reason)
            stopped = summary
            applied = Status.NOT_ASKED
        # a limit shorter than the caller's is looked at by the check that sets it
        new = [
            seen
            for seen in interview.seen[before:]
            if seen.answer.outcome is not Outcome.TIMEOUT or seen.limit == interview.limit
        ]
        silent = _wrong(interview, new, (Part.OUTCOME,))
        repeat = questions.check_command(interview.spec, name, interview.limit, interview.profile)
        listed = [
            replace(finding, command=finding.command or repeat)
            for finding in united(findings, silent)
        ]
        listed.sort(key=lambda finding: finding.status is not Status.FAIL)
        yield CheckResult(name, title, tuple(listed), summary, applied)
        outcomes = {seen.answer.outcome for seen in interview.seen}
        if interview.declared["unavailable"] is not None:
            stopped = f"it cannot run here: {interview.declared['unavailable']}"
        elif outcomes and Outcome.RETURNED not in outcomes:
            stopped = "no question was answered so far; mend that first"


def _not_asked(name: str, reason: str) -> CheckResult:
    return CheckResult(name, TITLES[name], summary=reason, applied=Status.NOT_ASKED)


def _names(checks: Iterable[str]) -> list[str]:
    """The checks in their order, `loading` first."""
    if isinstance(checks, str):
        checks = [checks]
    requested = list(checks)
    for name in requested:
        if name not in CHECKS:
            hint = did_you_mean(name, CHECKS)
            raise ConformanceError(
                f"no check named {short(name)}; {hint}choose from: {', '.join(CHECKS)}"
            )
    return [name for name in CHECKS if name in requested or name == "loading"]


def _spec_of(kind: Any) -> str:
    """A spec, or the spec of a class.

    The spec of a class is its registered name, or its file and name.
    """
    if isinstance(kind, str):
        return kind
    if not (isinstance(kind, type) and issubclass(kind, Solver)):
        raise ConformanceError(
            f"solver is {kind!r:.80}; expected a spec, or a class that extends Solver"
        )
    return registered_name(kind) or f"{getsourcefile(kind)}:{kind.__name__}"
