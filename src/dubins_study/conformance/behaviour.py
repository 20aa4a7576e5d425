"""Checks of what a solver does to its process, its time and itself."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from dubins_study.conformance import questions
from dubins_study.conformance.answers import unanswered
from dubins_study.conformance.findings import CheckResult, Finding, Status
from dubins_study.conformance.interview import Interview, Seen
from dubins_study.conformance.observer import RANDOM, TEMPORARY
from dubins_study.conformance.questions import check_command, command
from dubins_study.conformance.worker import GRACE_S
from dubins_study.experiments.isolation.pool import GRACE_S as RUN_GRACE_S
from dubins_study.solvers.protocol import Guarantee, Question
from dubins_study.study.path import Path
from dubins_study.study.words import BRANCHES, Outcome

# Seconds of a limit that a solver is given to be cut off by, and that it may take beyond a limit
# if it promises to keep it (`Solver.keeps_limit`).
_SHORT_LIMIT_S, _BEYOND_S = 0.05, 1.0
# relative: answers that differ by less differ in rounding only
_ROUNDING = 1e-12


def _question(interview: Interview, name: str) -> Question:
    """A general question of a branch that the solver answers."""
    scenario, branches = questions.GENERAL[name], interview.declared["branches"]
    known = [branch for branch in BRANCHES if branch in branches]
    return Question(scenario, "best" if "best" in known or not known else known[0])


def limits(interview: Interview, name: str, title: str) -> CheckResult:
    """A question with a limit of a twentieth of a second."""
    promised = interview.declared["keeps_limit"]
    question = _question(interview, "all at once")
    first = interview.ask(question)  # the libraries are loaded by now
    seen = interview.ask(question, again=True, limit=_SHORT_LIMIT_S)
    timed_out = seen.answer.outcome is Outcome.TIMEOUT
    silent = unanswered([first] if timed_out else [first, seen], "all at once")
    seconds = seen.answer.wall_s or seen.seconds
    # a run ends a solve sooner than the promise asks for
    beyond = _BEYOND_S if promised else RUN_GRACE_S
    if not timed_out and seconds <= _SHORT_LIMIT_S + beyond:
        summary = f"{seconds:.3f} s with a limit of {_SHORT_LIMIT_S} s"
        return CheckResult(name, title, silent, summary)
    observed = f"with a limit of {_SHORT_LIMIT_S} s it takes {seconds:.2f} s"
    if timed_out:
        observed = f"with a limit of {_SHORT_LIMIT_S} s it does not return within {GRACE_S:g} s"
    advice = (
        "look at `limit`, the second argument of solve, and return the best path so far with "
        "Claim.LIMIT; a run ends the process at the limit and keeps no path"
    )
    status = Status.NOTE
    if promised:
        status, advice = Status.FAIL, f"{advice}. Until then, do not promise keeps_limit"
    shown = command(interview.spec, question) + f" --time-limit {_SHORT_LIMIT_S}"
    late = Finding(status, observed, advice, "all at once", shown)
    return CheckResult(name, title, (*silent, late))


# Solves of at least so many seconds, each of them so many times sooner when it is asked again, are
# no solves: libraries are loaded before, and a busy machine does not spare the same four questions.
_LEAST_TIMED_S, _FAR_SOONER = 1e-3, 20.0
# A solver that tosses a coin for each answer passes once in 4^4 times.
_ASKED_AGAIN = (
    *("target ahead to the left", "target behind to the right"),
    *("all at once", "all at once, other side"),
)


def determinism(interview: Interview, name: str, title: str) -> CheckResult:
    """Some questions, again after one another, and again in a new process."""
    known = [_question(interview, place) for place in _ASKED_AGAIN]
    first = [interview.ask(question) for question in known]
    second = [interview.ask(question, again=True) for question in known]
    interview.restart()
    third = [interview.ask(question, again=True) for question in known]
    found = []
    for seen, when in ((second, "after other questions"), (third, "in a new process")):
        for place, one, again in zip(_ASKED_AGAIN, first, seen, strict=True):
            found += _changed(one, again, when, place, check_command(interview.spec, name))
    silent = unanswered([*first, *second, *third], "")
    worst = sorted(found, key=lambda one: one.status is not Status.FAIL)[:1]
    listed = (*silent, *worst, *_kept_answers(first, second), *_repeat(interview, first[0]))
    if not listed and all(seen.answer.path is None for seen in first):
        return CheckResult(name, title, (), "it returned no path", Status.NOT_APPLICABLE)
    return CheckResult(name, title, listed, f"{len(known)} questions, three times the same")


def _changed(first: Seen, again: Seen, when: str, place: str, shown: str) -> list[Finding]:
    """What tells the answers to one question apart; nothing where they are the same."""
    difference = _difference(first, again)
    if difference is None:
        return []
    observed = f"asked again {when}, its answer differs by {difference:.2g} of the length"
    if difference == np.inf:
        observed = f"asked again {when}, it answers {_said(again)}; the first time {_said(first)}"
    advice = (
        "draw random numbers from a generator of the solver's own, seeded in build or solve "
        "by a setting and question.repeat, and keep nothing between questions"
    )
    status = Status.NOTE if difference <= _ROUNDING else Status.FAIL
    return [Finding(status, observed, advice, place, shown)]


def _kept_answers(first: list[Seen], second: list[Seen]) -> list[Finding]:
    """A note if questions are answered far sooner when they are asked again.

    A solver that keeps its answers is timed once in a run; its repeats take no time.
    """
    times = [
        (one.answer.solve_s or 0.0, again.answer.solve_s or 0.0)
        for one, again in zip(first, second, strict=True)
    ]
    if not all(one > _LEAST_TIMED_S and again < one / _FAR_SOONER for one, again in times):
        return []
    one, again = times[-1]
    observed = f"asked again, it answers in {again:.3g} s; the first time it took {one:.3g} s"
    advice = "keep no answers: in a run, repeats would be timed without any solving"
    return [Finding(Status.NOTE, observed, advice, _ASKED_AGAIN[-1])]


def _repeat(interview: Interview, first: Seen) -> list[Finding]:
    """What another repeat of a question shows, of a solver that says it is stochastic."""
    if interview.declared["guarantee"] != Guarantee.STOCHASTIC:
        return []
    again = interview.ask(replace(first.question, repeat=1))
    if _difference(first, again) is not None:
        return []
    observed = "it is stochastic, and its second repeat is the same as its first"
    advice = "add question.repeat to the seed: repeats then tell how much is luck"
    return [Finding(Status.NOTE, observed, advice)]


def _said(seen: Seen) -> str:
    answer = seen.answer
    return f"{answer.outcome}, {answer.claim}, {answer.word or 'no path'}"


def _difference(first: Seen, second: Seen) -> float | None:
    """How far two answers differ (share of the length); infinite if not only in numbers."""
    one, other = first.answer, second.answer
    if (one.outcome, one.claim) != (other.outcome, other.claim):
        return float(np.inf)
    if one.path is None or other.path is None:
        return None if one.path is other.path else float(np.inf)
    return _apart(one.path, other.path)


def _apart(one: Path, other: Path) -> float | None:
    if one.length.shape != other.length.shape:
        return float(np.inf)
    controls = (one.curvature, other.curvature), (one.length, other.length)
    if all(np.array_equal(*pair, equal_nan=True) for pair in controls):
        return 0.0 if one.start != other.start else None
    scale = max(one.total_length, 1e-300)
    turned = np.abs(one.curvature * one.length - other.curvature * other.length).max(initial=0.0)
    return float(max(np.abs(one.length - other.length).max(initial=0.0) / scale, turned))


# state -> what to do instead of changing it
_ADVICE = {
    "working directory": "give other programs a folder by their own option, or `cwd=`",
    "environment variables": "give a program its own `env=`",
    "sys.path": "import what you need as a package",
    "warnings filters": "use `with warnings.catch_warnings():`",
    "numpy's error handling": "use `with np.errstate(...):`",
    "decimal context": "use `with decimal.localcontext():`",
    "signal handlers": "restore the handlers that were there",
    "timers": "switch your timer off before you return",
    "threads": "end your threads before you return",
    "child processes": "wait for your processes before you return",
    "standard streams": "use `contextlib.redirect_stdout` with a file of your own",
    "memory or files": "close what you open, and keep no model between questions",
}
_CHANGED = (
    "a run then replaces the worker after every question, which takes longer than most solves"
)


def state(interview: Interview, name: str, title: str) -> CheckResult:
    """What all questions so far have left behind; libraries load with the first one.

    At least the general questions: they are asked now if no other check has asked them.
    """
    before = len(interview.seen)
    for other in questions.GENERAL:
        interview.ask(_question(interview, other))
    seen = interview.seen
    promised = interview.declared["keeps_limit"]
    shown = check_command(interview.spec, name)
    found = [*unanswered(seen[before:], "")]
    changed = Counter(change for one in seen for change in one.changes)
    for change, count in changed.items():
        advice = f"{_ADVICE.get(change, 'restore it before you return')}; {_CHANGED}"
        status = Status.FAIL
        if change == RANDOM:
            status = Status.NOTE
            advice = "draw from a generator of your own: np.random.default_rng(seed)"
        observed = f"after a solve this is not as it was before: {change}"
        found.append(Finding(status, observed, advice, "", shown, count=count))
    found += [replace(one, command=shown) for one in _files(seen)]
    loud = [one for one in seen if one.output and not one.loaded]
    if loud:
        last = " ".join(loud[0].output.split())[-120:]
        advice = "switch the output of the library off, or leave print out"
        status = Status.FAIL if promised else Status.NOTE
        found.append(Finding(status, f"it prints: {last}", advice, "", shown, count=len(loud)))
    found.sort(key=lambda one: one.status is not Status.FAIL)
    return CheckResult(name, title, tuple(found), f"{len(seen)} questions")


def _files(seen: list[Seen]) -> list[Finding]:
    """Files that were left where the solver was started, or among temporary files."""
    files = sorted({file for one in seen for file in one.files if one.answer.outcome in _ENDED})
    found = []
    for status, place, mine in (
        (Status.FAIL, "the working directory", lambda file: not file.startswith(TEMPORARY)),
        (Status.NOTE, "the folder for temporary files", lambda file: file.startswith(TEMPORARY)),
    ):
        if left := [file.removeprefix(f"{TEMPORARY}/") for file in files if mine(file)]:
            observed = f"it leaves files in {place}: {', '.join(left[:3])}"
            advice = "write into a tempfile.TemporaryDirectory()"
            found.append(Finding(status, observed, advice, count=len(left)))
    return found


# outcomes after which a solver could have removed its files
_ENDED = (Outcome.RETURNED, Outcome.RAISED)
