"""The section on failures.

It has what happened, the solvers' messages, and a command that repeats each failure.
"""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import LATE, PRESOLVED, SUCCESSES, first_true
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, sentences, share, some
from dubins_study.study.scenario_frame import solve_command

# Outcomes of a process that was stopped, and of one that was never called.
STOPPED = ("timeout", "crashed", "raised", "out_of_memory")
OUTCOMES = (*STOPPED, "unavailable", "not_asked")
# Kinds of failures; the first that holds counts.
KINDS = ("no return", "no path", "misses", "longer")
# Columns that name an example; the plainest example is the first in their order.
_EXAMPLE = (
    "warm",
    "repeat",
    "distance",
    "x",
    "y",
    "heading",
    "target_x",
    "target_y",
    "radius",
    "branch",
    "profile",
    "experiment",
)
_BY_MESSAGE = ["solver", "outcome", "claim", "verdict", "message"]


def gist(message: str) -> str:
    """A message without numbers and repeated parts.

    Each number becomes `#`, so that similar messages count as one.
    """
    parts = [re.sub(r"\d[\d.]*(?:[eE][+-]?\d+)?", "#", part) for part in message.split("; ")]
    return "; ".join(dict.fromkeys(parts))[:160]


def kinds_of(attempts: pd.DataFrame) -> pd.Series[str]:
    """The kind of each attempt's failure, or empty.

    The kind is the first of `KINDS` that holds. A failure is an attempt at a question that has a
    path, without an answer that the check accepts.
    """
    verdict = attempts["verdict"]
    conditions = {
        "": ~attempts["answerable"] | verdict.isin((*SUCCESSES, PRESOLVED)),
        "no return": attempts["outcome"].ne("returned") | verdict.eq(LATE),
        "misses": verdict.eq("misses"),
        "longer": verdict.eq("longer"),
    }
    return first_true(conditions, "no path")


def plainest(attempts: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The plainest attempt of each group.

    The columns `keys` define the groups. The plainest attempt is the first by the columns
    `_EXAMPLE`: cold if the group has a cold one, then the first repeat, then the nearest target.
    """
    warm = attempts["initial_guess"].ne("cold")
    dx = attempts["target_x"] - attempts["x"]
    dy = attempts["target_y"] - attempts["y"]
    placed = attempts.assign(warm=warm, distance=np.sqrt(dx**2 + dy**2) / attempts["radius"])
    return placed.sort_values(list(_EXAMPLE), kind="stable").drop_duplicates(keys)


def failures(attempts: pd.DataFrame) -> pd.DataFrame:
    """Failures counted by solver, outcome and message.

    Failures of stopped processes come first, then the most frequent. Columns: solver, outcome,
    claim, verdict, message (the status if there is no message), attempts, and the columns of an
    example, the plainest attempt.
    """
    failed = attempts[kinds_of(attempts) != ""]
    messages = failed["message"].replace("", None).fillna(failed["native_status"]).fillna("")
    failed = failed.assign(message=messages.map({text: gist(text) for text in messages.unique()}))
    sums = failed.groupby(_BY_MESSAGE, dropna=False).size().rename("attempts").reset_index()
    joined = sums.merge(plainest(failed, _BY_MESSAGE), on=_BY_MESSAGE, how="left")
    joined["stopped"] = joined["outcome"].isin(STOPPED)
    order = ["stopped", "attempts", *_BY_MESSAGE]
    return joined.sort_values(order, ascending=[False, False] + [True] * len(_BY_MESSAGE))


def with_commands(table: pd.DataFrame) -> pd.DataFrame:
    """The table of `failures` with a column `command`.

    The command asks the example again, under the example's time limit.
    """
    limits = table["limit_s"].astype(object).where(table["limit_s"].notna(), None)
    lines = table.assign(time_limit_s=limits).to_dict("records")
    return table.assign(command=[solve_command(line) for line in lines])


_MOST = 25
_TITLE = "Failures"
_KIND_TEXT = {
    "no return": "did not return",
    "no path": "returned without a path",
    "misses": "returned a path that misses the target",
    "longer": "returned a longer path",
}


def failures_section(results: Results | None) -> Section:
    """The section with failures by message, and commands.

    The results of an empty run are None.
    """
    untaken = ""
    if results is not None:
        untaken = _untaken_text(results.untaken)
    if results is None or results.rows.empty:
        lead = "No attempt was recorded, so nothing is known to have failed."
        return Section("failures", _TITLE, untaken, (), lead)
    attempts = results.attempts
    lost = attempts["outcome"].value_counts().reindex(OUTCOMES, fill_value=0)
    kinds = kinds_of(attempts).value_counts().reindex(KINDS, fill_value=0)
    answerable = int(attempts["answerable"].sum())
    failed = int(kinds.sum())
    blocks: list[Table] = []
    if failed:
        messages = failures(attempts).head(_MOST).reset_index(drop=True)
        blocks.append(_message_table(with_commands(messages)))
    lead = "Nothing failed."
    if failed or lost.any():
        lead = "Read the messages of failures; the command beside each repeats one."
    text = sentences(_lost_text(lost, len(attempts)), _failed_text(kinds, answerable), untaken)
    return Section("failures", _TITLE, text, tuple(blocks), lead)


def _lost_text(lost: pd.Series[int], total: int) -> str:
    """A sentence on attempts that did not return.

    The text is empty if all returned.
    """
    if not lost.any():
        return ""
    parts = [f"{count(n)} {str(name).replace('_', ' ')}" for name, n in lost.items() if n]
    return f"{count(lost.sum())} of {some(total, 'attempt')} did not return ({', '.join(parts)})."


def _failed_text(kinds: pd.Series[int], total: int) -> str:
    """A sentence on how many attempts failed, by kind.

    `total` is the number of attempts at questions that have a path. The text is empty if none
    failed.
    """
    failed = kinds.sum()
    if not failed:
        return ""
    parts = [f"{count(n)} {_KIND_TEXT[str(kind)]}" for kind, n in kinds.items() if n]
    return (
        f"Of {some(total, 'attempt')} at questions that have a path, {count(failed)} failed "
        f"({share(failed / total)}): {', '.join(parts)}. Where no path exists, an attempt without "
        "a path has not failed."
    )


def _untaken_text(untaken: pd.DataFrame) -> str:
    """A sentence on questions that solvers do not take.

    Such questions are no attempts. The text is empty if there are none.
    """
    if untaken.empty:
        return ""
    most = untaken.groupby("solver").size().idxmax()
    return (
        f"{some(len(untaken), 'more question')} were for a solver that does not take them "
        f"(unsupported), most often {most}. No share counts them."
    )


def _message_table(table: pd.DataFrame) -> Table:
    """The table of failures by message."""
    shown = (
        SOLVER,
        *columns(kind="text", outcome="outcome", claim="claim", verdict="verdict"),
        *columns(kind="prose", message="what the solver said"),
        *columns(count, attempts="attempts"),
        *columns(kind="command", command="ask again"),
    )
    caption = (
        f"Failures by message (# stands for a number), at most {_MOST} lines: stopped processes "
        "first, then the most frequent. The command repeats one of them, cold and at the nearest "
        "target, under the time limit of its run."
    )
    return Table("failures", caption, table, shown, numbers=("experiment",), dense=True)


TOPIC = Topic("failures", failures_section, General.POOLED)
