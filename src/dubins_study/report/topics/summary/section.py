"""The first section: every solver's attempts in one table."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import pandas as pd

from dubins_study.report.data.attempts import EXACT, PRESOLVED, Attempts
from dubins_study.report.data.results import Results
from dubins_study.report.data.verdicts import methods, starts, verdicts
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import Section, Table
from dubins_study.report.elements.formats import count, seconds, sentences, share, some
from dubins_study.report.elements.identity import METHOD
from dubins_study.report.elements.names import in_page_order
from dubins_study.report.elements.shares import INTERVAL_TEXT
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import best_of_formulations
from dubins_study.report.topics.summary.numbers import STARTS, by_start, summary

# The spec instead of the settings: it is what a reader hands to the command.
_COLUMNS = (
    *METHOD[:-1],
    SOLVER,
    *columns(kind="cell", right_text="right of n, 95 %"),
    *(Column(key, key, count) for key in ("none exists", PRESOLVED)),
    *columns(count, longer="longer", misses="misses", none="none"),
    *columns(count, false_claims="false claims", wrong_basins="wrong basins"),
    *columns(count, not_returned="not returned"),
    *columns(seconds, wall_s="median time"),
)
_NUMBERS = ("attempts", "questions", "optimal", "right_share", "right_low", "right_high")


def solver_summary(attempts: Attempts) -> pd.DataFrame:
    """The table `summary` of attempts."""
    return summary(verdicts(attempts), methods(attempts))


def best_solvers(results: Results) -> tuple[str, ...]:
    """The closed form, and of each formulation the solver that is most surely right."""
    if results not in _BEST:
        methods = solver_summary(results.attempts)
        _BEST[results] = (EXACT, *best_of_formulations(methods))
    return _BEST[results]


_BEST: WeakKeyDictionary[Results, tuple[str, ...]] = WeakKeyDictionary()


def summary_table(name: str, caption: str, frame: pd.DataFrame, first: tuple[Column, ...]) -> Table:
    """A table of `summary`, with columns before it; columns without any count are left out."""
    rare = [key for key in ("none exists", PRESOLVED, "not_returned") if not frame[key].any()]
    shown = [column for column in _COLUMNS if column.key not in rare]
    bad = marks(frame, "misses", "none", "false_claims", "not_returned")
    return Table(name, caption, frame, (*first, *shown), bad, _NUMBERS, dense=True)


def summary_section(results: Results) -> Section | None:
    """Verdicts and times where a path exists, solver by solver."""
    attempts = results.attempts
    frame = solver_summary(attempts)
    solvers = len(attempts.values("solver"))
    caption = sentences(
        "Questions that have a path. Right: the check finds the answer optimal; shares are of all "
        f"questions, those that failed included. {INTERVAL_TEXT} The other columns count attempts.",
        "By presolve: the setting presolve answered that no path exists, and no engine was asked."
        if frame[PRESOLVED].any()
        else "",
        "A false claim says more than the check finds; a wrong basin is a longer path that turns "
        "by another angle. Not returned: timed out, crashed, raised, unsupported or unavailable.",
    )
    experiments = list(
        dict.fromkeys(run.name for run in results.folders if run.name in attempts.experiments)
    )
    questions, without = frame["questions"].sum(), attempts.count - int(frame["attempts"].sum())
    text = sentences(
        f"{some(attempts.count, 'attempt')} by {some(solvers, 'solver')} in the "
        f"{'experiment' if len(experiments) == 1 else 'experiments'} {', '.join(experiments)}.",
        f"Right where a path exists: {share(frame['right'].sum() / questions)}."
        if questions
        else "",
        f"{some(without, 'attempt')} {'was' if without == 1 else 'were'} at questions that have no "
        "path; whether solvers recognise that stands in the section on existence, and no number "
        "here counts it."
        if without
        else "",
        "No number here rests on a solver's own word: each path is driven again from its controls "
        "and judged against the closed form.",
    )
    lead = "Look up how one solver did: right, wrong, silent, and in what time."
    table = summary_table("summary", caption, frame, ())
    started = in_page_order(by_start(starts(attempts)), results)
    tables = (table, _start_table(started)) if len(started) else (table,)
    return Section("summary", "Summary", text, tables, lead)


def _start_table(frame: pd.DataFrame) -> Table:
    caption = (
        "Cold and warm starts apart, at the questions that a solver was asked both ways. Warm: the "
        "search began at the answer to a neighbouring question. Shares with their 95 % interval "
        "(Wilson); a trial is a scenario with a branch, repeats are its parts."
    )
    shown = (SOLVER, *columns(kind="cell", cold_text="right, cold", warm_text="right, warm"))
    numbers = tuple(f"{start}_{end}" for start in STARTS for end in ("share", "low", "high"))
    return Table("summary-by-start", caption, frame, shown, numbers=numbers)


TOPIC = Topic("summary", summary_section, General.POOLED, counted=True)
