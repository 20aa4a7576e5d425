"""The section that says first what the study found."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Place, Section, Table
from dubins_study.report.elements.formats import count, some
from dubins_study.report.elements.identity import interval_keys
from dubins_study.report.elements.topic import BENCHMARK, Topic
from dubins_study.report.statistics.compared import compared
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.finding import ENOUGH, Finding
from dubins_study.report.topics.findings.numbers import ADVICE, findings

_MOST = 10


def findings_section(results: Results) -> Section | None:
    """Sentences to act on, each computed from the rows; None if the rows carry none."""
    attempts = compared(results)
    if attempts is None:
        return None
    every = findings(Evidence(attempts), ADVICE)
    if not every:
        return None
    tables = [_table("findings", every[:_MOST], 1, "What a practitioner can act on.")]
    if every[_MOST:]:
        tables.append(_table("findings-more", every[_MOST:], _MOST + 1, "Further findings."))
    text = (
        "Every sentence is computed from the rows: it is said only if its 95 % interval excludes "
        f"that there is no difference, and if at least {ENOUGH} questions carry it."
    )
    lead = (
        f"Read {some(len(every), 'sentence')} to act on, the first of them on what matters most; "
        "each names the section that shows where it comes from."
    )
    return Section("findings", "What the study found", text, tuple(tables), lead)


# The sections that findings point to show other means of the same times.
_RATIOS = (
    "A ratio of times is that of two medians over the questions that both methods answer, of each "
    "question the median repeat; both medians stand beside it. Tables that count failures, weigh "
    "every attempt, or show shifted means have other quotients. "
)


def _table(name: str, chosen: Sequence[Finding], first: int, title: str) -> Table:
    frame = pd.DataFrame(
        [
            {
                "place": first + number,
                "sentence": finding.sentence,
                "value": finding.estimate.value,
                "value_low": finding.estimate.low,
                "value_high": finding.estimate.high,
                "unit": finding.unit,
                "question": finding.question,
                "shown_in": finding.shown_in,
            }
            for number, finding in enumerate(chosen)
        ]
    )
    shown = (
        *columns(count, place="no."),
        *columns(kind="prose", sentence="finding"),
        *columns(kind="prose", question="asked of"),
        *columns(kind="section", shown_in="shown in"),
    )
    caption = (
        f"{title} Intervals: Wilson's for shares, for as many trials as there are questions, and "
        f"bootstrap over scenarios for all others. {_RATIOS}The CSV file holds the numbers apart."
    )
    return Table(
        name, caption, frame, shown, numbers=(*interval_keys("value"), "unit"), stacked=True
    )


TOPIC = Topic("what the study found", findings_section, BENCHMARK, place=Place.FRONT)
