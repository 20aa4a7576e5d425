"""The findings of all checks of a solver.

They form its report, with the text for a terminal.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from itertools import groupby
from textwrap import fill, indent
from typing import Any

from dubins_study.study.values import plain, printable_text
from dubins_study.study.words import Verdict


class Status(StrEnum):
    """How a check ended, mildest first.

    `note` is worth knowing and no fault: a local solver's longer path, for instance. `not asked`
    means that the time ran out, or that the solver cannot run here.
    """

    NOT_APPLICABLE = "not applicable"
    PASS = "pass"
    NOTE = "note"
    NOT_ASKED = "not asked"
    FAIL = "fail"


class Part(StrEnum):
    """Part of an answer that a finding is about."""

    OUTCOME = "outcome"
    CONTROLS = "controls"
    CLAIM = "claim"
    BOUND = "bound"
    LENGTH = "length"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that a check has seen.

    Args:
        status: `fail` or `note`.
        observed: what was seen, a sentence.
        advice: what to do about it, a sentence; empty if nothing needs doing.
        question: the name of the scenario it was seen at; empty if it is about no scenario.
        command: the command that asks the question again.
        traceback: of an exception, the solver's own frames.
        count: at how many questions the same was seen.
        kind: the part of an answer that it is about; None if it is about no answer.
    """

    status: Status
    observed: str
    advice: str = ""
    question: str = ""
    command: str = ""
    traceback: str = ""
    count: int = 1
    kind: Part | None = None


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The outcome of one check.

    Args:
        name: as in `CHECKS`.
        title: what is checked.
        findings: what was seen, failures first; empty if all is well.
        summary: a few words on what passed, or why the check was not applied.
        applied: `pass` if the check was applied, else `not applicable` or `not asked`.
    """

    name: str
    title: str
    findings: tuple[Finding, ...] = ()
    summary: str = ""
    applied: Status = Status.PASS

    @property
    def status(self) -> Status:
        """The worst status among the findings.

        If there are none: `pass`, or why the check was not applied.
        """
        statuses = [self.applied, *(finding.status for finding in self.findings)]
        return max(statuses, key=list(Status).index)

    @property
    def passed(self) -> bool:
        """Whether the check has passed.

        Nothing failed, and the check was applied or need not be.
        """
        return self.status not in (Status.FAIL, Status.NOT_ASKED)


@dataclass(frozen=True, slots=True, repr=False)
class ConformanceReport:
    """The outcome of all checks of one solver.

    As a text, it is what a terminal shows.

    Args:
        solver: its spec.
        results: one for each check, in the order of `CHECKS`.
        answers: how many of its answers have each verdict; `unanswered` are those where it raised,
            crashed or hung.
        seconds: how long that took.
        worst_gap: of the paths that are longer than the shortest, the largest gap; None without.
        claimed: how many of its answers claim a path, or that there is none.
    """

    solver: str
    results: tuple[CheckResult, ...]
    answers: dict[str, int]
    seconds: float
    worst_gap: float | None = None
    claimed: int = 0

    @property
    def passed(self) -> bool:
        """Whether every check passed.

        Notes are no failures; checks that were not made are.
        """
        return all(result.passed for result in self.results)

    def __getitem__(self, name: str) -> CheckResult:
        return {result.name: result for result in self.results}[name]

    def __iter__(self) -> Iterator[CheckResult]:
        return iter(self.results)

    def with_status(self, status: Status) -> tuple[CheckResult, ...]:
        """The results of the checks with a status."""
        return tuple(result for result in self.results if result.status is status)

    def __str__(self) -> str:
        return report_text(self)

    __repr__ = __str__

    def to_dict(self) -> dict[str, Any]:
        """The report as values that JSON can hold."""
        checks = [
            {
                "name": result.name,
                "title": result.title,
                "status": result.status,
                "summary": result.summary,
                "findings": [asdict(finding) for finding in result.findings],
            }
            for result in self.results
        ]
        return {
            "solver": self.solver,
            "passed": self.passed,
            "counts": {status: len(self.with_status(status)) for status in reversed(Status)},
            "answers": self.answers,
            "worst_gap": self.worst_gap,
            "claimed": self.claimed,
            "seconds": round(self.seconds, 3),
            "checks": checks,
        }


_WIDTH = 100
_LEAST_WIDTH = 30
_MARGIN = " " * 6
# status -> its mark before a check, and how the verdict counts such checks, worst first
_STATUS_TEXTS = {
    Status.FAIL: ("FAIL", "failed"),
    Status.NOT_ASKED: ("  ? ", "not asked"),
    Status.NOTE: ("note", "with notes"),
    Status.PASS: ("pass", "passed"),
    Status.NOT_APPLICABLE: ("  – ", "not applicable"),
}


def report_text(report: ConformanceReport, width: int | None = None) -> str:
    """All checks, with their findings and the verdict.

    A check has a line, with its findings below. The verdict comes last.

    Lines fit the terminal's `width` and 100 characters; commands and tracebacks are never broken.
    """
    width = max(min(width or _WIDTH, _WIDTH), _LEAST_WIDTH)
    earlier_advice: set[str] = set()  # the same advice is given once
    blocks = []
    for (status, _), group in groupby(report, key=_together):
        result, *others = group
        mark, _ = _STATUS_TEXTS[status]
        if others:
            names = ", ".join(check.name for check in (result, *others))
            line = f"{mark}  {names}: {plain(result.summary)}"
        else:
            line = f"{mark}  {result.name:<12} {result.title}"
            if result.summary:
                line += f" ({plain(result.summary)})"
        blocks.append(_wrapped(line, width, _MARGIN))
        for finding in result.findings:
            if finding.advice in earlier_advice:
                finding = replace(finding, advice="", traceback="")
            elif finding.advice:
                earlier_advice.add(finding.advice)
            blocks.append(indent(_finding_text(finding, width - len(_MARGIN)), _MARGIN))
    last = [_wrapped(line, width, "  ") for line in _verdict(report)]
    return "\n".join([plain(report.solver), "", *blocks, "", *last])


def _together(result: CheckResult) -> tuple[Status, object]:
    """The key of checks that share a line.

    Checks that were not made, all for one reason, have the same key. Every other check has a key of
    its own.
    """
    if result.status is Status.NOT_ASKED and not result.findings:
        return result.status, result.summary
    return result.status, result


def _finding_text(finding: Finding, width: int) -> str:
    """A finding as lines: observation, advice, traceback, command."""
    observed = plain(finding.observed)
    if finding.question:
        observed = f"{plain(finding.question)}: {observed}"
    if finding.count > 1:
        observed += f" (and {finding.count - 1} more)"
    lines = [_wrapped(observed, width)]
    if finding.advice:
        lines.append(_wrapped(f"→ {plain(finding.advice)}", width, "  "))
    if finding.traceback:
        lines.append(indent(printable_text(finding.traceback.rstrip()), "  "))
    if finding.command and finding.status is Status.FAIL:
        lines.append(f"$ {plain(finding.command)}")
    return "\n".join(lines)


def _wrapped(text: str, width: int, hanging: str = "") -> str:
    return fill(
        text, width, subsequent_indent=hanging, break_long_words=False, break_on_hyphens=False
    )


def _verdict(report: ConformanceReport) -> Iterator[str]:
    """Yield the sentences at the end of a report.

    The first tells whether the report passed, the number of checks by status, and longer paths. The
    second has the number of questions, the time, and the answers by verdict. A third follows if
    no answer claims anything.
    """
    counts = [
        f"{len(report.with_status(status))} {name}"
        for status, (_, name) in _STATUS_TEXTS.items()
        if report.with_status(status)
    ]
    total = sum(report.answers.values())
    longer = ""
    if report.worst_gap is not None:
        longer = (
            f"; paths longer than the shortest on {report.answers[Verdict.LONGER]} of {total} "
            f"questions, worst {100 * report.worst_gap:.3g} %"
        )
    outcome = "FAILED"
    if report.passed:
        outcome = "passed"
    yield f"{outcome}: {', '.join(counts)}{longer}"
    questions = f"{total} questions in {report.seconds:.1f} s"
    endings = ", ".join(f"{count} {name}" for name, count in report.answers.items() if count)
    if endings:
        questions += f": {endings}"
    yield questions
    if total and not report.claimed:
        yield "It claims nothing of any answer: no check can find a claim of its false."
