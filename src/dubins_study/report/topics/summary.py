"""Every solver's attempts at questions that have a path, in one table."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data import verdicts as counts
from dubins_study.report.data.attempts import EXACT, PRESOLVED, UNDECIDED, Attempts
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, seconds, sentences, share, some
from dubins_study.report.elements.identity import INTERVAL_TEXT, METHOD, with_share
from dubins_study.report.elements.looks import in_page_order
from dubins_study.report.statistics.methods import best_of_formulations, methods_of, once

STARTS = ("cold", "warm")


def by_start(starts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver of `report.data.verdicts.starts`, with shares right for cold and warm."""
    frame = starts[["solver"]].drop_duplicates(ignore_index=True)
    for start in STARTS:
        rows = starts[starts["initial_guess"] == start].set_index("solver")
        right, questions = (
            frame["solver"].map(rows[name]).fillna(0) for name in ("right", "questions")
        )
        frame = with_share(frame, start, right, questions)
    return frame


def summary(verdicts: pd.DataFrame, methods: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: verdicts, false claims, wrong basins and times where a path exists.

    Solvers that were asked no such question are left out, unless none was. The columns of
    `report.data.verdicts.verdicts` and `methods`, those of `methods_of`, in its order, and those of
    `with_share` for right, a share of the questions.
    """
    asked = verdicts["questions"] > 0
    counted = verdicts[asked] if asked.any() else verdicts
    frame = with_share(counted, "right", counted["right"], counted["questions"])
    named = methods_of(methods[methods["solver"].isin(counted["solver"])])
    return named.join(frame.set_index("solver")).reset_index()


# The spec instead of the settings: it is what a reader hands to the command.
_COLUMNS = (
    *METHOD[:-1],
    SOLVER,
    *columns(kind="cell", right_text="right of n, 95 %"),
    *(Column(key, key, count) for key in ("none exists", PRESOLVED)),
    *columns(count, longer="longer", misses="misses", none="none"),
    *columns(count, undecided="undecided"),
    *columns(count, false_claims="false claims", wrong_basins="wrong basins"),
    *columns(count, not_returned="not returned"),
    *columns(seconds, wall_s="median time"),
)
_NUMBERS = ("attempts", "questions", "optimal", "right_share", "right_low", "right_high")


def solver_summary(attempts: Attempts) -> pd.DataFrame:
    """The table `summary` of attempts."""
    return summary(counts.verdicts(attempts), counts.methods(attempts))


@once
def best_solvers(results: Results) -> tuple[str, ...]:
    """The closed form, and of each formulation the solver that is most surely right."""
    return (EXACT, *best_of_formulations(solver_summary(results.attempts)))


def summary_table(name: str, caption: str, frame: pd.DataFrame, first: tuple[Column, ...]) -> Table:
    """A table of `summary`, with columns before it; columns without any count are left out."""
    rare = [
        key for key in ("none exists", PRESOLVED, UNDECIDED, "not_returned") if not frame[key].any()
    ]
    shown = [column for column in _COLUMNS if column.key not in rare]
    bad = marks(frame, "misses", "none", "false_claims", "not_returned")
    return Table(name, caption, frame, (*first, *shown), bad, _NUMBERS, dense=True)


def summary_section(results: Results) -> Section | None:
    """Verdicts and times where a path exists, solver by solver."""
    attempts = results.attempts
    frame = solver_summary(attempts)
    solvers = len(attempts.values("solver"))
    caption = sentences(
        "Questions that have a path and that the solver takes. Right: the check finds the answer "
        f"optimal; failed attempts count. {INTERVAL_TEXT} The other columns count attempts.",
        "By presolve: the setting presolve answered that no path exists, and no engine was asked."
        if frame[PRESOLVED].any()
        else "",
        "Undecided: the shortest length is not known well enough; such attempts enter no share."
        if frame[UNDECIDED].any()
        else "",
        "A false claim says more than the check finds; a wrong basin is a longer path that turns "
        "by another angle. Not returned: timed out, crashed, raised or unavailable.",
    )
    experiments = list(
        dict.fromkeys(run.name for run in results.folders if run.name in attempts.experiments)
    )
    questions, without = (
        frame["questions"].sum(),
        attempts.count - int(frame[["attempts", UNDECIDED]].sum().sum()),
    )
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
    started = in_page_order(by_start(counts.starts(attempts)), results)
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


TOPIC = Topic("summary", summary_section, General.POOLED)
