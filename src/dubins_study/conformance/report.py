"""The report of all checks of a solver, and how a terminal shows it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from itertools import groupby
from textwrap import fill, indent
from typing import Any

from dubins_study.conformance.findings import CheckResult, Finding, Status
from dubins_study.study.values import plain, printable_text


@dataclass(frozen=True, slots=True, repr=False)
class ConformanceReport:
    """The outcome of all checks of one solver; as a text, what a terminal shows.

    Args:
        solver: its spec.
        results: one for each check, in the order of `CHECKS`.
        answers: how many of its answers are shortest, longer, right that there is no path, none
            (although there is a path), missing the target, or unanswered: it raised, crashed, hung.
        seconds: how long that took.
    """

    solver: str
    results: tuple[CheckResult, ...]
    answers: dict[str, int]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether every check passed; notes are no failures, checks that were not made are."""
        return all(result.passed for result in self.results)

    def __getitem__(self, name: str) -> CheckResult:
        return {result.name: result for result in self.results}[name]

    def __iter__(self) -> Iterator[CheckResult]:
        return iter(self.results)

    def with_status(self, status: Status) -> tuple[CheckResult, ...]:
        """The checks that ended so."""
        return tuple(result for result in self.results if result.status is status)

    def __str__(self) -> str:
        return report_text(self)

    __repr__ = __str__

    def to_dict(self) -> dict[str, Any]:
        """The report as values that JSON can hold."""
        checks = [
            {"name": one.name, "title": one.title, "status": one.status, "summary": one.summary}
            | {"findings": [asdict(found) for found in one.findings]}
            for one in self.results
        ]
        counts = {status: len(self.with_status(status)) for status in reversed(Status)}
        return {
            "solver": self.solver,
            "passed": self.passed,
            "counts": counts,
            "answers": self.answers,
            "seconds": round(self.seconds, 3),
            "checks": checks,
        }


_WIDTH, _LEAST_WIDTH = 100, 30
_MARKS = {
    Status.PASS: "pass",
    Status.NOTE: "note",
    Status.FAIL: "FAIL",
    Status.NOT_APPLICABLE: "  – ",
    Status.NOT_ASKED: "  ? ",
}
_MARGIN = " " * 6


def report_text(report: ConformanceReport, width: int | None = None) -> str:
    """All checks, a line each, with their findings below; the verdict last.

    Args:
        report: of a solver.
        width: of the terminal; lines are shorter than that and 100 characters. Commands and
            tracebacks are never broken.
    """
    width = max(min(width or _WIDTH, _WIDTH), _LEAST_WIDTH)
    shown: dict[str, str] = {}  # advice -> the check that gave it first
    blocks = []
    for (status, _), group in groupby(report, key=_together):
        results = list(group)
        if len(results) > 1:
            names = ", ".join(result.name for result in results)
            line = f"{_MARKS[status]}  {names}: {plain(results[0].summary)}"
            blocks.append(_wrapped(line, width, _MARGIN))
            continue
        [result] = results
        line = f"{_MARKS[result.status]}  {result.name:<12} {_about(result)}"
        blocks.append(_wrapped(line, width, _MARGIN))
        for place, found in enumerate(result.findings, 1):
            later = [one for one in result.findings[place:] if one.status is Status.FAIL]
            if found.command in [one.command for one in later]:
                found = replace(found, command="")  # one command repeats them all: below the last
            earlier = shown.get(found.advice) if found.status is Status.FAIL else None
            blocks.append(indent(_finding(found, earlier, width - len(_MARGIN)), _MARGIN))
            shown.setdefault(found.advice or found.observed, result.name)
    last = [_wrapped(line, width, "  ") for line in verdict(report).splitlines()]
    return "\n".join([plain(report.solver), "", *blocks, "", *last])


def _together(result: CheckResult) -> tuple[Status, object]:
    """Checks that were not made for one reason are one line; all others are lines of their own."""
    same = result.status is Status.NOT_ASKED and not result.findings
    return result.status, result.summary if same else result


def _about(result: CheckResult) -> str:
    summary = f" ({plain(result.summary)})" if result.summary else ""
    return f"{result.title}{summary}"


def _finding(found: Finding, earlier: str | None, width: int) -> str:
    more = f" (and {found.count - 1} more)" if found.count > 1 else ""
    where = f"{plain(found.question)}: " if found.question else ""
    lines = [_wrapped(f"{where}{plain(found.observed)}{more}", width)]
    if earlier is not None:
        lines.append(f"→ as in {earlier}")
    elif found.advice:
        lines.append(_wrapped(f"→ {plain(found.advice)}", width, "  "))
    if found.traceback and earlier is None:
        lines.append(indent(printable_text(found.traceback.rstrip()), "  "))
    if found.command and found.status is Status.FAIL:
        lines.append(f"$ {plain(found.command)}")
    return "\n".join(lines)


def _wrapped(text: str, width: int, hanging: str = "") -> str:
    return fill(
        text,
        width,
        subsequent_indent=hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )


def verdict(report: ConformanceReport) -> str:
    """Two lines: whether the report passed, how many checks ended how, and so the answers."""
    counts = [
        f"{len(results)} {name}"
        for status, name in (
            (Status.FAIL, "failed"),
            (Status.NOT_ASKED, "not asked"),
            (Status.NOTE, "with notes"),
            (Status.PASS, "passed"),
            (Status.NOT_APPLICABLE, "not applicable"),
        )
        if (results := report.with_status(status))
    ]
    word = "passed" if report.passed else "FAILED"
    asked = f"{sum(report.answers.values())} questions in {report.seconds:.1f} s"
    ended = ", ".join(f"{count} {name}" for name, count in report.answers.items() if count)
    return f"{word}: {', '.join(counts)}\n{asked}{': ' if ended else ''}{ended}"
