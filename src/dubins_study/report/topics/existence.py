"""The section on existence: who recognises that no path exists."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import (
    PRESOLVED,
    SUCCESSES,
    UNDECIDED,
    is_true,
    methods,
    questions,
)
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import seconds, sentences, share, some
from dubins_study.report.elements.identity import method_columns, with_share
from dubins_study.report.elements.identity import questions as question_count
from dubins_study.report.statistics.methods import methods_of
from dubins_study.report.topics.summary import share_keys

_ANSWERS = ("right", "silent", "wrong")
KINDS = ("presolved", "unasked", *_ANSWERS)


def existence(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver that was asked a question without a path, or that denied a path.

    Columns of `methods_of`; of the questions without a path: presolved, unasked (the solver is not
    installed), reached (that reached the engine), and of these right, wrong (a false claim) and
    silent (no claim); wall_s (median of the attempts that reached the engine, s); of those that
    have a path: questions, denied (claimed infeasible); those of `with_share` for right, silent and
    wrong, shares of `reached`, and for denied, a share of `questions`.
    """
    there, verdict, false = attempts["answerable"], attempts["verdict"], attempts["false_claim"]
    conditions = {
        "": there | verdict.eq(UNDECIDED),
        "presolved": verdict.eq(PRESOLVED),
        "unasked": attempts["outcome"].eq("unavailable"),
        "right": verdict.isin(SUCCESSES),
        "wrong": is_true(false),
    }
    kind = pd.Series(np.select([*conditions.values()], [*conditions], "silent"), attempts.index)
    denied = there & attempts["claim"].eq("infeasible") & is_true(false)
    chosen = {name: kind.eq(name) for name in KINDS} | {"questions": there, "denied": denied}
    counts = pd.DataFrame({name: questions(attempts, which) for name, which in chosen.items()})
    times = attempts["wall_s"].where(kind.isin(_ANSWERS))
    counts["wall_s"] = times.groupby(attempts["solver"]).median()
    frame = methods_of(methods(attempts)).join(counts).reset_index()
    frame["reached"] = frame[list(_ANSWERS)].sum(axis="columns").round(6)
    for name in _ANSWERS:
        frame = with_share(frame, name, frame[name], frame["reached"])
    frame = with_share(frame, "denied", frame["denied"], frame["questions"])
    asked = (frame[["reached", "presolved"]] > 0).any(axis="columns")
    return frame[asked | (frame["denied"] > 0)].reset_index(drop=True)


_LEAD = "See who proves that no path exists, who says nothing, and who is wrong."
_COLUMNS = (
    *columns(question_count, presolved="by presolve"),
    *columns(kind="cell", right_text="right", silent_text="silent", wrong_text="wrong"),
    *columns(seconds, wall_s="median time"),
    *columns(kind="cell", denied_text="denies a path"),
)
_NUMBERS = (
    *("solver", "unasked", "reached"),
    *share_keys(*_ANSWERS),
    *("questions", "denied", *share_keys("denied")),
)


def existence_section(results: Results) -> Section | None:
    """Right, silent and wrong answers where no path exists; paths that are denied."""
    frame = existence(results.attempts)
    if not (frame[["reached", "presolved"]].any(axis=None)):
        return None
    text = _text(frame)
    return Section("existence", "Where no path exists", text, (_table(frame),), _LEAD)


def _text(frame: pd.DataFrame) -> str:
    reached, presolved = frame["reached"].sum(), frame["presolved"].sum()
    total = reached + presolved
    names = ("right", "silent", "wrong") if reached else ()
    parts = [f"{name}: {share(frame[name].sum() / reached)}" for name in names]
    denied = frame[frame["denied"] > 0]
    worst = denied.sort_values("denied_share", kind="stable").tail(1).to_dict("records")
    return sentences(
        "To recognise that no path exists is another task than to find one; a search that fails "
        "where there is nothing to find has missed nothing.",
        f"The presolve alone answers {share(presolved / total)} of the questions without a path."
        if presolved
        else "",
        f"Of those that reached an engine, {', '.join(parts)}." if parts else "",
        *(
            f"{len(denied)} of {len(frame)} solvers call a question infeasible that has a path, "
            f"most often {row['name']}: {share(row['denied_share'])} of "
            f"{some(int(row['questions']), 'question')}."
            for row in worst
        ),
    )


def _table(frame: pd.DataFrame) -> Table:
    caption = (
        "Questions without a path, solver by solver. By presolve: elementary geometry excluded "
        "them, and no engine was asked. Of those that reached the engine, right: it claims that "
        "none exists; silent: it failed, reached a limit or claims nothing; wrong: it claims a "
        "path; and the median time of these attempts, whatever they say. Denies a path: of the "
        "questions that have one, the share that it calls infeasible. Shares with their 95 % "
        "interval (Wilson), for as many trials as there are questions; a repeat is a part of one."
    )
    bad = frame.assign(wrong_text=frame["wrong"] > 0, denied_text=frame["denied"] > 0)
    return Table(
        "existence",
        caption,
        frame,
        (*method_columns(frame), *_COLUMNS),
        marks(bad, "wrong_text", "denied_text"),
        _NUMBERS,
        dense=True,
    )


TOPIC = Topic("where no path exists", existence_section, General.POOLED)
