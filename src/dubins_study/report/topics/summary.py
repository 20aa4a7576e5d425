"""A table of every solver's attempts.

Only questions that have a path count.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import (
    LATE,
    PRESOLVED,
    SUCCESSES,
    UNDECIDED,
    VERDICTS,
    is_true,
    methods,
    questions,
)
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, seconds, some
from dubins_study.report.elements.identity import INTERVAL_TEXT, METHOD, with_share
from dubins_study.report.statistics.methods import methods_of
from dubins_study.study.words import Outcome


def solver_summary(attempts: pd.DataFrame) -> pd.DataFrame:
    """Counts, shares and times, one row per solver.

    Only questions that have a path count. Solvers that were asked no such question are left out,
    unless none was.

    Returns:
        The columns of `methods_of`, in its order, and these:

        attempts, questions, right: numbers of attempts, of questions, and of right ones of these.
        One column for each of `VERDICTS`: attempts with this verdict.
        undecided: attempts with this verdict, which `attempts` does not count.
        false_claims, wrong_basins, not_returned (timeout, crashed, raised, ...): attempts.
        wall_s: median time, s; missing if no attempt returned.
        Those of `with_share` for right, a share of the questions.
    """
    solver = attempts["solver"]
    verdict = attempts["verdict"]
    answerable = attempts["answerable"]
    returned = attempts["outcome"].eq("returned")
    flags = {
        **{name: verdict.eq(name) for name in VERDICTS},
        "attempts": answerable,
        "not_returned": ~returned,
        "false_claims": is_true(attempts["false_claim"]),
        "wrong_basins": is_true(attempts["wrong_basin"]),
    }
    counts = {name: answerable & flag for name, flag in flags.items()}
    counts[UNDECIDED] = verdict.eq(UNDECIDED)
    frame = pd.DataFrame(counts).groupby(solver).sum()
    frame["questions"] = questions(attempts, answerable)
    frame["right"] = questions(attempts, answerable & verdict.isin(SUCCESSES))
    times = attempts["wall_s"].where(answerable).groupby(solver).median()
    frame["wall_s"] = times.where((answerable & returned).groupby(solver).any())
    if answerable.any():
        frame = frame[frame["attempts"] > 0]
    frame = with_share(frame, "right", frame["right"], frame["questions"])
    stated = methods(attempts)
    return methods_of(stated[stated["solver"].isin(frame.index)]).join(frame).reset_index()


def share_keys(*names: str) -> tuple[str, ...]:
    """The columns that `with_share` adds for names, as numbers.

    `share_keys("right") -> ("right_share", "right_low", "right_high")`. The CSV file gets them.
    """
    keys: list[str] = []
    for name in names:
        keys += [f"{name}_share", f"{name}_low", f"{name}_high"]
    return tuple(keys)


# The spec instead of the settings: a reader passes it to the command.
_COLUMNS = (
    *METHOD[:-1],
    SOLVER,
    *columns(kind="cell", right_text="right of n, 95 %"),
    *(Column(key, key, count) for key in ("none exists", PRESOLVED, LATE)),
    *columns(count, longer="longer", misses="misses", none="none"),
    *columns(count, undecided="undecided"),
    *columns(count, false_claims="false claims", wrong_basins="wrong basins"),
    *columns(count, not_returned="not returned"),
    *columns(seconds, wall_s="median time"),
)
_NUMBERS = ("attempts", "questions", "optimal", *share_keys("right"))


def summary_section(results: Results) -> Section | None:
    """The section with verdicts and times, solver by solver.

    Only questions that have a path count.
    """
    attempts = results.attempts
    frame = solver_summary(attempts)
    caption = (
        "Questions that have a path and that the solver takes. Right: the check finds the answer "
        f"optimal; failed attempts count. {INTERVAL_TEXT} The other columns count attempts. By "
        "presolve: presolve answered that no path exists, and no engine was asked. Undecided: the "
        "shortest length is not known well enough; no share counts such attempts. The glossary "
        "defines false claims and wrong basins. Not returned: timed out, crashed, raised or "
        "unavailable; or not asked, since the solver had failed on shorter routes."
    )
    experiments = dict.fromkeys(run.name for run in results.folders)
    attempts_made = int(attempts["outcome"].ne(Outcome.NOT_ASKED).sum())
    text = (
        f"{some(attempts_made, 'attempt')} by {some(attempts['solver'].nunique(), 'solver')} in "
        f"{', '.join(experiments)}. The section on existence has the attempts at questions without "
        "a path. No number rests on a solver's own word: each path is driven again from its "
        "controls. Its length is compared with the closed form, or with the proven bounds of a "
        "route."
    )
    lead = "Look up one solver: how often it is right, wrong or silent, and how fast."
    rare = [
        key
        for key in ("none exists", PRESOLVED, LATE, UNDECIDED, "not_returned")
        if not frame[key].any()
    ]
    shown = tuple(column for column in _COLUMNS if column.key not in rare)
    bad = marks(frame, "misses", "none", "false_claims", "not_returned")
    table = Table("summary", caption, frame, shown, bad, _NUMBERS, dense=True)
    return Section("summary", "Summary", text, (table,), lead)


TOPIC = Topic("summary", summary_section, General.POOLED)
