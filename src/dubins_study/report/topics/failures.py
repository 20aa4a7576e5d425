"""The section on failures: what happened, what solvers said, and how to repeat one."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import LATE, PRESOLVED, SUCCESSES
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, sentences, share, some
from dubins_study.study.scenario_frame import solve_command

# Outcomes of a process that was stopped, and of one that was never called.
STOPPED = ("timeout", "crashed", "raised", "out_of_memory")
OUTCOMES = (*STOPPED, "unavailable", "not_asked")
# What a failure is, the first that holds.
KINDS = ("no return", "no path", "misses", "longer")
# What names an example, in the order in which a plainer one is chosen.
_EXAMPLE = (
    *("warm", "repeat", "distance", "x", "y", "heading", "target_x", "target_y"),
    *("radius", "branch", "profile", "experiment"),
)
_SAID = ["solver", "outcome", "claim", "verdict", "message"]


def gist(message: str) -> str:
    """A message without numbers and repetitions, so that similar messages count as one."""
    parts = [re.sub(r"\d[\d.]*(?:[eE][+-]?\d+)?", "#", part) for part in message.split("; ")]
    return "; ".join(dict.fromkeys(parts))[:160]


def kinds_of(attempts: pd.DataFrame) -> pd.Series[str]:
    """The first of `KINDS` that holds of each attempt; empty if it has not failed.

    A failure is an attempt at a question that has a path, without an answer that the check accepts.
    """
    verdict = attempts["verdict"]
    conditions = {
        "": ~attempts["answerable"] | verdict.isin((*SUCCESSES, PRESOLVED)),
        "no return": attempts["outcome"].ne("returned") | verdict.eq(LATE),
        "misses": verdict.eq("misses"),
        "longer": verdict.eq("longer"),
    }
    kinds = np.select([*conditions.values()], [*conditions], "no path")
    return pd.Series(kinds, attempts.index)


def plainest(attempts: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The first by `_EXAMPLE` of each group of attempts: cold if there is a cold one."""
    warm = attempts["initial_guess"].ne("cold")
    dx, dy = (attempts[f"target_{name}"] - attempts[name] for name in "xy")
    placed = attempts.assign(warm=warm, distance=np.sqrt(dx**2 + dy**2) / attempts["radius"])
    return placed.sort_values(list(_EXAMPLE), kind="stable").drop_duplicates(keys)


def failures(attempts: pd.DataFrame) -> pd.DataFrame:
    """Failures counted by outcome, claim, verdict and the gist of the message.

    Those of stopped processes first, then the largest.
    Columns: solver, outcome, claim, verdict, message (of the status if there is no message),
    attempts; those of an example, the first repeat with the nearest target.
    """
    failed = attempts[kinds_of(attempts) != ""]
    said = failed["message"].replace("", None).fillna(failed["native_status"]).fillna("")
    failed = failed.assign(message=said.map({text: gist(text) for text in said.unique()}))
    sums = failed.groupby(_SAID, dropna=False).size().rename("attempts").reset_index()
    joined = sums.merge(plainest(failed, _SAID), on=_SAID, how="left")
    joined["stopped"] = joined["outcome"].isin(STOPPED)
    order = ["stopped", "attempts", *_SAID]
    return joined.sort_values(order, ascending=[False, False] + [True] * len(_SAID))


def with_commands(table: pd.DataFrame) -> pd.DataFrame:
    """The table of `failures` with `command`: what repeats the example, under its limit (s)."""
    limits = table["limit_s"].astype(object).where(table["limit_s"].notna(), None)
    lines = table.assign(time_limit_s=limits).to_dict("records")
    return table.assign(command=[solve_command(line) for line in lines])


_MOST = 25
_TITLE = "Failures"
_KIND_TEXT = {
    "no return": "did not return",
    "no path": "returned without a path",
    "misses": "brought a path that misses the target",
    "longer": "brought a longer path",
}


def failures_section(results: Results | None) -> Section:
    """Failures by message, with commands; results are None of an empty run."""
    untaken = "" if results is None else _untaken_text(results.untaken)
    if results is None or results.rows.empty:
        lead = "No attempt was recorded, so nothing is known to have failed."
        return Section("failures", _TITLE, untaken, (), lead)
    attempts = results.attempts
    lost = attempts["outcome"].value_counts().reindex(OUTCOMES, fill_value=0)
    kinds = kinds_of(attempts).value_counts().reindex(KINDS, fill_value=0)
    asked, failed = int(attempts["answerable"].sum()), int(kinds.sum())
    blocks: list[Table] = []
    if failed:
        messages = failures(attempts).head(_MOST).reset_index(drop=True)
        blocks.append(_message_table(with_commands(messages)))
    lead = "Nothing failed."
    if failed or lost.any():
        lead = "See what was said of failures; the command beside it repeats one of them."
    text = sentences(_lost_text(lost, len(attempts)), _failed_text(kinds, asked), untaken)
    return Section("failures", _TITLE, text, tuple(blocks), lead)


def _lost_text(lost: pd.Series[int], total: int) -> str:
    """How many attempts did not return, and why; empty if all did."""
    if not lost.any():
        return ""
    parts = [f"{count(n)} {str(name).replace('_', ' ')}" for name, n in lost.items() if n]
    return f"{count(lost.sum())} of {some(total, 'attempt')} did not return ({', '.join(parts)})."


def _failed_text(kinds: pd.Series[int], asked: int) -> str:
    """How many attempts at questions with a path failed, by kind; empty if none did."""
    failed = kinds.sum()
    if not failed:
        return ""
    parts = [f"{count(n)} {_KIND_TEXT[str(kind)]}" for kind, n in kinds.items() if n]
    return (
        f"Of {some(asked, 'attempt')} at questions that have a path, {count(failed)} failed "
        f"({share(failed / asked)}): {', '.join(parts)}. An attempt that found none where no path "
        "exists has not failed."
    )


def _untaken_text(untaken: pd.DataFrame) -> str:
    """How many questions solvers do not take, which are no attempts."""
    if untaken.empty:
        return ""
    most = untaken.groupby("solver").size().idxmax()
    return (
        f"{some(len(untaken), 'more question')} met a solver that does not take "
        f"them (unsupported), most often {most}: it was not called, and no "
        "share counts them."
    )


def _message_table(table: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(kind="text", outcome="outcome", claim="claim", verdict="verdict"),
        *columns(kind="prose", message="what the solver said"),
        *columns(count, attempts="attempts"),
        *columns(kind="command", command="ask again"),
    )
    caption = (
        f"Failures by what was said of them (# stands for a number), at most {_MOST} lines: first "
        "those of stopped processes, then the most frequent. The command repeats one of them, cold "
        "and at the nearest target, under the time limit of its run."
    )
    return Table("failures", caption, table, shown, numbers=("experiment",), dense=True)


TOPIC = Topic("failures", failures_section, General.POOLED)
