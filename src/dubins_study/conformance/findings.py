"""What a conformance check has found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


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


_RANK = list(Status)


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
    """

    status: Status
    observed: str
    advice: str = ""
    question: str = ""
    command: str = ""
    traceback: str = ""
    count: int = 1


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The outcome of one check.

    Args:
        name: as in `CHECKS`.
        title: what is checked.
        findings: what was seen; empty if all is well.
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
        """The worst of the findings' statuses; `pass` or why not, where there are none."""
        return max([self.applied, *(found.status for found in self.findings)], key=_RANK.index)

    @property
    def passed(self) -> bool:
        """Whether the check was applied, or need not be, and nothing failed."""
        return self.status not in (Status.FAIL, Status.NOT_ASKED)
