"""The section on what not to conclude."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Section, Table
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.compared import compared
from dubins_study.report.topics.caution.numbers import Caution, cautions
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.numbers import WARNINGS, findings

_BENCHMARK = "benchmark"


def caution_section(results: Results) -> Section | None:
    """Conclusions that the rows do not carry; None without attempts to compare."""
    attempts = compared(results)
    if attempts is None:
        return None
    every = cautions(results, attempts)
    # As the findings, from a benchmark only: elsewhere the methods met different questions.
    if any(folder.section == _BENCHMARK for folder in results.folders):
        every = [
            *(
                Caution(f.sentence, f.estimate.value, f.unit, f.question, f.shown_in)
                for f in findings(Evidence(attempts), WARNINGS)
            ),
            *every,
        ]
    lead = "Read these sentences before you quote a number from this page."
    return Section("caution", "What not to conclude", "", (_table(every),), lead)


def _table(every: list[Caution]) -> Table:
    shown = (
        *columns(kind="prose", sentence="what not to conclude"),
        *columns(kind="prose", of="number of"),
        *columns(kind="section", shown_in="shown in"),
    )
    caption = "Each number is computed from the rows and the runs' manifests."
    frame = pd.DataFrame(every)
    return Table("caution", caption, frame, shown, numbers=("value", "unit"), stacked=True)


TOPIC = Topic("what not to conclude", caution_section, General.DECIDED)
