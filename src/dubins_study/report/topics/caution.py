"""The section on what not to conclude.

Each line is a conclusion that the rows do not support, with a number from the rows.
"""

from __future__ import annotations

from typing import NamedTuple

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, share, some
from dubins_study.report.statistics.intervals import wilson_intervals
from dubins_study.report.statistics.methods import Compared, compared
from dubins_study.study.words import FORMULATIONS, Outcome

# The precision of shares is given at this share: most methods that matter lie near it.
_TYPICAL_SHARE = 0.9
_STOPPED_OUTCOMES = ("timeout", "out_of_memory")


class Caution(NamedTuple):
    """A conclusion that the rows do not support.

    `of` says of how many questions or attempts the number is; `shown_in` names the section that
    shows it.
    """

    sentence: str
    of: str
    shown_in: str


def overlapping_shares(attempts: Compared) -> Caution | None:
    """Caution: do not rank methods by shares alone.

    The sentence says how precise a share is with this many questions.
    """
    by_experiment = attempts.answerable.groupby("experiment")["question"].nunique()
    if by_experiment.empty:
        return None
    questions = int(by_experiment.min())
    low, high = wilson_intervals(_TYPICAL_SHARE * questions, questions)
    points = 100 * (high - low) / 2
    return Caution(
        f"Do not rank methods by their shares alone: a share of {share(_TYPICAL_SHARE)} is known "
        f"to ±{digits(2)(points)} percentage points. Use the paired tests; overlapping intervals "
        "decide nothing.",
        f"{some(questions, 'question')} with a path, the fewest of an experiment; less well of a "
        "sample",
        "Summary",
    )


def unsteady_machine(results: Results) -> Caution | None:
    """Caution: do not rank by small differences in time.

    The sentence says how much the speed of the machines varied during a run. None if no run
    measured it.
    """
    spreads: list[float] = []
    for folder in results.folders:
        spreads += [run.spread for run in folder.manifest.runs if run.spread is not None]
    if not spreads:
        return None
    return Caution(
        f"Do not rank methods by times that differ by less than {share(max(spreads))}: the speed "
        "of the machine varied by this much during a run.",
        f"{some(len(spreads), 'run')} that timed a fixed piece of work",
        "The runs and their machines",
    )


def stopped_attempts(attempts: Compared) -> Caution | None:
    """Caution: a stopped attempt says nothing of the question.

    None if no attempt ended at a limit.
    """
    rows = attempts.answerable
    rows = rows[(rows["solver"] != EXACT) & (rows["outcome"] != Outcome.NOT_ASKED)]
    stopped = rows["outcome"].isin(_STOPPED_OUTCOMES) | (rows["claim"] == "limit")
    number = int(stopped.fillna(False).sum())
    if not number:
        return None
    return Caution(
        f"Do not conclude that a method cannot solve a question: {some(number, 'attempt')} ended "
        f"at a limit of time ({seconds(attempts.limit_s)} at most) or of iterations.",
        f"{some(len(rows), 'attempt')} of engines at questions with a path",
        "Success and gaps",
    )


def missing_pairs(results: Results, attempts: Compared) -> Caution | None:
    """Caution: nothing is known of pairs without rows.

    A pair is a formulation and an engine. None if all pairs have rows.
    """
    # the closed form is a formulation without an engine, and no pair
    entries: set[tuple[str, str]] = set()
    for folder in results.folders:
        pairs = {(entry.formulation, entry.engine) for entry in folder.manifest.matrix}
        entries |= {pair for pair in pairs if FORMULATIONS[0] not in pair}
    methods = attempts.engines
    with_rows = set(zip(methods["formulation"], methods["engine"], strict=True))
    missing = len(entries - with_rows)
    if not missing:
        return None
    return Caution(
        f"Do not conclude anything about missing pairs: {count(missing)} of "
        f"{count(len(entries | with_rows))} pairs of a formulation and an engine have no rows.",
        "all formulations with all engines",
        "Formulation by engine",
    )


def caution_section(results: Results) -> Section | None:
    """The section of cautions; None without attempts to compare."""
    attempts = compared(results)
    if attempts is None:
        return None
    cautions: list[Caution | None] = [
        overlapping_shares(attempts),
        unsteady_machine(results),
        stopped_attempts(attempts),
        missing_pairs(results, attempts),
    ]
    shown = (
        *columns(kind="prose", sentence="what not to conclude"),
        *columns(kind="prose", of="number of"),
        *columns(kind="section", shown_in="shown in"),
    )
    caption = "Each number is computed from the rows and the runs' manifests."
    frame = pd.DataFrame([caution for caution in cautions if caution is not None])
    table = Table("caution", caption, frame, shown, stacked=True)
    lead = "Read these sentences before you quote a number from this page."
    return Section("caution", "What not to conclude", "", (table,), lead)


TOPIC = Topic("what not to conclude", caution_section, General.DECIDED)
