"""Checks of a solver's declaration, process and time.

The checks look at what a solver declares, and at its effects on its process and its time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from itertools import chain

import numpy as np

from dubins_study.asking.attempt import Answer
from dubins_study.conformance import questions
from dubins_study.conformance.interview import (
    GRACE_S,
    Interview,
    LoadError,
    NotApplicableError,
    Seen,
)
from dubins_study.conformance.report import Finding, Status
from dubins_study.experiments.isolation.pool import GRACE_S as RUN_GRACE_S
from dubins_study.solvers.protocol import Question
from dubins_study.study.kinds.table import EVERY_KIND
from dubins_study.study.words import Outcome

Checked = tuple[Iterable[Finding], str]  # the findings, and a few words on the answers that passed
# part of the message of a solver that does not load -> what to do, where it is not the file
_BROKEN = {
    "required positional argument": "give each setting a default, such as `n: int = 10`",
    "cannot be made": "its class is called with no arguments, and with settings; it must not raise",
    "": "the file has to load by itself: python {file} must not raise",
}


def broken(error: LoadError, spec: str, command: str) -> Finding:
    """The finding about a solver that does not load."""
    message = str(error)
    file = spec.rpartition(":")[0] or "my_solver.py"
    advice = next(text for part, text in _BROKEN.items() if part in message)
    observed, _, place = message.partition("\n")  # of a syntax error
    return Finding(
        Status.FAIL,
        observed,
        advice=advice.format(file=file),
        command=command,
        traceback=place or error.frames,
    )


def loading(interview: Interview) -> Checked:
    """Check a solver's declaration.

    The findings are the problems that `observer.declaration` has seen.
    """
    declared = interview.declared
    formulation, engine = declared["method"][:2]
    findings = [Finding(Status(status), *texts) for status, *texts in declared["problems"]]
    return findings, f"{declared['name']}: {formulation}, {engine}"


def _question(interview: Interview, place: int) -> Question:
    """A simple question that the solver takes.

    `place` is the question's index among those of one kind. It may be negative or too large: beyond
    the last question the count begins again.
    """
    for kind in EVERY_KIND:
        scenarios = [*interview.taken(questions.OF_KIND[kind.name]).values()]
        branches = [branch for branch in kind.branches if interview.answers(branch)]
        if scenarios and branches:
            return Question(scenarios[place % len(scenarios)], branches[0])
    raise NotApplicableError("the solver takes none of the kit's questions")


# index of a question in general position, in the table of every kind
_ALL_AT_ONCE = -2
# Seconds of a limit that is to cut a solver off.
_SHORT_LIMIT_S = 0.05
# Seconds beyond a limit for a solver that promises to keep it (`Solver.keeps_limit`).
_BEYOND_S = 1.0


def limits(interview: Interview) -> Checked:
    """Check the time of a solve with 0.05 s.

    A solver that promises `keeps_limit` fails if it takes over a second more. Any other gets a note
    if a run would have ended it.
    """
    promised = interview.declared["keeps_limit"]
    question = _question(interview, _ALL_AT_ONCE)
    interview.ask(question)  # the libraries are loaded by now
    seen = interview.ask(question, again=True, limit=_SHORT_LIMIT_S)
    timed_out = seen.answer.outcome is Outcome.TIMEOUT
    seconds = seen.answer.wall_s or seen.seconds
    beyond = RUN_GRACE_S  # a run ends a solve sooner than the promise asks for
    if promised:
        beyond = _BEYOND_S
    if not timed_out and seconds <= _SHORT_LIMIT_S + beyond:
        return [], f"{seconds:.3f} s with a limit of {_SHORT_LIMIT_S} s"
    took = f"it takes {seconds:.2f} s"
    if timed_out:
        took = f"it does not return within {GRACE_S:g} s"
    advice = (
        "look at `limit`, the second argument of solve, and return the best path so far with "
        "Claim.LIMIT; a run ends the process at the limit and keeps no path"
    )
    status = Status.NOTE
    if promised:
        status = Status.FAIL
        advice += ". Until then, do not promise keeps_limit"
    finding = Finding(
        status,
        f"with a limit of {_SHORT_LIMIT_S} s {took}",
        advice=advice,
        question=question.scenario.label,
        command=questions.command(interview.spec, question, _SHORT_LIMIT_S, interview.profile),
    )
    return [finding], ""


# share of the length: poses that differ by less differ in rounding only
_ROUNDING = 1e-12
# share of its limit that a cut-off engine uses: it looks at the clock between its steps
_WHOLE_LIMIT = 0.9
# A solver that tosses a coin for each answer passes once in 4^4 times.
_ASKED_AGAIN = (0, 1, -2, -1)


def determinism(interview: Interview) -> Checked:
    """Ask some questions three times.

    The second time is after other questions, the third in a new process. Answers that took the
    whole limit are not compared.
    """
    repeated = [_question(interview, place) for place in _ASKED_AGAIN]
    first = [interview.ask(question) for question in repeated]
    second = [interview.ask(question, again=True) for question in repeated]
    interview.source.restart()
    third = [interview.ask(question, again=True) for question in repeated]
    advice = (
        "draw random numbers from a generator of the solver's own, seeded in build or solve "
        "by a setting and question.repeat, and keep nothing between questions"
    )
    compared = 0
    findings = []
    for answers, when in ((second, "after other questions"), (third, "in a new process")):
        for earlier, later in zip(first, answers, strict=True):
            if _is_cut(earlier) or _is_cut(later):
                continue
            compared += 1
            if not _is_same(earlier.answer, later.answer):
                observed = (
                    f"asked again {when}, its answer differs by more than rounding: "
                    f"{_summary(later.answer)}; the first time {_summary(earlier.answer)}"
                )
                label = earlier.question.scenario.label
                findings.append(Finding(Status.FAIL, observed, advice=advice, question=label))
    if not compared:
        raise NotApplicableError("its answers took the whole time limit; raise --time-limit")
    if not findings and all(seen.answer.path is None for seen in first):
        raise NotApplicableError("it returned no path")
    summary = f"{compared} pairs of answers the same"
    cut = 2 * len(repeated) - compared
    if cut:
        summary += f"; of {cut} more pairs one took the whole time limit"
    return findings[:1], summary


def _is_cut(seen: Seen) -> bool:
    """Whether an answer took its whole limit.

    Then the machine's speed has a part in it.
    """
    return (seen.answer.wall_s or seen.seconds) > _WHOLE_LIMIT * seen.limit


def _summary(answer: Answer) -> str:
    return f"{answer.outcome}, {answer.claim}, {answer.word or 'no word'}, length {answer.length}"


def _is_same(one: Answer, other: Answer) -> bool:
    """Whether two answers differ in rounding only."""
    if (one.outcome, one.claim) != (other.outcome, other.claim):
        return False
    if one.path is None or other.path is None:
        return one.path is other.path
    if one.path.lengths.shape != other.path.lengths.shape:
        return False
    allowed = _ROUNDING * one.path.length
    with np.errstate(all="ignore"):
        return np.allclose(one.path.poses, other.path.poses, rtol=0, atol=allowed, equal_nan=True)


# state -> what to do instead of changing it
_ADVICE = {
    "working directory": "give other programs a folder by their own option, or `cwd=`",
    "environment variables": "give a program its own `env=`",
    "numpy's error handling": "use `with np.errstate(...):`",
    "threads": "end your threads before you return",
    "child processes": "wait for your processes before you return",
    "standard streams": "use `contextlib.redirect_stdout` with a file of your own",
    "memory or files": "close what you open, and keep no model between questions",
}


def state(interview: Interview) -> Checked:
    """Find the traces that the questions have left.

    Traces are changed state of the process, files in its folder, and printed text. All questions so
    far count.
    """
    # so that the general ones are among them, whichever checks are made
    for number in range(len(questions.GENERAL)):
        interview.ask(_question(interview, number))
    findings = [*_changes(interview), *_files_left(interview), *_printed(interview)]
    return findings, f"{len(interview.seen)} questions"


def _changes(interview: Interview) -> Iterable[Finding]:
    """Yield a finding for each state that has changed."""
    changes = Counter(chain.from_iterable(seen.observed.changes for seen in interview.seen))
    for change, count in changes.items():
        advice = (
            f"{_ADVICE.get(change, 'restore it before you return')}; a run then replaces the "
            "worker after every question, which takes longer than most solves"
        )
        observed = f"after a solve this is not as it was before: {change}"
        yield Finding(Status.FAIL, observed, advice=advice, count=count)


def _files_left(interview: Interview) -> Iterable[Finding]:
    """Yield a finding if solves have left files."""
    # after any other outcome a solver could not have removed its files
    ended = (Outcome.RETURNED, Outcome.RAISED)
    files_left = [seen.files for seen in interview.seen if seen.answer.outcome in ended]
    files = sorted(set(chain.from_iterable(files_left)))
    if files:
        observed = f"it leaves files in the working directory: {', '.join(files[:3])}"
        advice = "write into a tempfile.TemporaryDirectory()"
        yield Finding(Status.FAIL, observed, advice=advice, count=len(files))


def _printed(interview: Interview) -> Iterable[Finding]:
    """Yield a finding if solves have printed text.

    It is a failure only of a solver that promises `keeps_limit`: to print nothing is a part of that
    promise.
    """
    # what is printed while modules are imported does not count: a library may do so at loading
    outputs = [
        seen.observed.output
        for seen in interview.seen
        if seen.observed.output and not seen.observed.loaded
    ]
    if outputs:
        advice = "switch the output of the library off, or leave print out"
        status = Status.NOTE
        if interview.declared["keeps_limit"]:
            status = Status.FAIL
        observed = f"it prints: {outputs[0][-120:]}"
        yield Finding(status, observed, advice=advice, count=len(outputs))
