"""The section on failures: what happened, what solvers said, where, and how to repeat one."""

from __future__ import annotations

import re
from collections.abc import Mapping

import pandas as pd

from dubins_study.report.data import failures as counts
from dubins_study.report.data.command import ROUTE, solve_command
from dubins_study.report.data.failures import KINDS, OUTCOMES, REACH
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import General, Section, Table, Topic
from dubins_study.report.elements.formats import count, sentences, share, some

_SAID = ["solver", "outcome", "claim", "verdict", "message"]
# (region, near or None for both) -> its line in the table.
_REGIONS = {
    ("outside", False): f"outside, beyond {REACH:g} R of the start",
    ("outside", True): f"outside, within {REACH:g} R of the start",
    ("circle", None): "on a turning circle",
    ("left disc", None): "in the left disc",
    ("right disc", None): "in the right disc",
}
_UNKNOWN = "no region: a route, a final heading, or no answer judged"


def gist(message: str) -> str:
    """A message without numbers and repetitions, so that similar messages count as one."""
    parts = [re.sub(r"\d[\d.]*(?:[eE][+-]?\d+)?", "#", part) for part in message.split("; ")]
    return "; ".join(dict.fromkeys(parts))[:160]


def unreturned(outcomes: pd.DataFrame) -> pd.DataFrame:
    """The solvers of which an attempt did not return, the most often stopped first.

    The columns of `report.data.failures.outcomes`, and unreturned: the number of attempts.
    """
    counted = outcomes.assign(unreturned=outcomes[list(OUTCOMES)].sum(axis="columns"))
    stopped = counted[counted["unreturned"] > 0]
    return stopped.sort_values(["unreturned", "solver"], ascending=[False, True], ignore_index=True)


def failures(frame: pd.DataFrame) -> pd.DataFrame:
    """Failures counted by outcome, claim, verdict and the gist of the message, largest first.

    The columns of `report.data.failures.failures`; of messages with one gist, the plainest example.
    """
    ascending = [False] + [True] * len(_SAID)
    counted = frame.assign(message=frame["message"].map(gist))
    example = [name for name in frame.columns if name not in {*_SAID, "attempts", *ROUTE}]
    plainest = counted.sort_values(example, kind="stable").drop_duplicates(_SAID)
    sums = counted.groupby(_SAID, dropna=False)["attempts"].sum().reset_index()
    joined = sums.merge(plainest.drop(columns="attempts"), on=_SAID, how="left")
    return joined.sort_values(["attempts", *_SAID], ascending=ascending)


def with_commands(table: pd.DataFrame, limits: Mapping[str, float | None]) -> pd.DataFrame:
    """The table of `failures` with `command`: what repeats the example, under its limit (s)."""
    lines = [
        row | {"time_limit_s": limits.get(row["experiment"])} for row in table.to_dict("records")
    ]
    return table.assign(command=[solve_command(line) for line in lines])


def by_region(frame: pd.DataFrame) -> pd.DataFrame:
    """The share of failures of each kind where the target lies, of `report.data.failures.regions`.

    place, in a fixed order; attempts, failed (a number), failed_share, and for each of `KINDS` its
    share.
    """
    lines = []
    region, near = frame["region"], frame["near"].fillna(False).astype(bool)
    for (name, close), title in _REGIONS.items():
        lines.append((title, frame[(region == name) & ((near == close) | (close is None))]))
    lines.append((_UNKNOWN, frame[~region.isin([name for name, _ in _REGIONS])]))
    sums = {title: rows[["attempts", *KINDS]].sum() for title, rows in lines if len(rows)}
    table = pd.DataFrame.from_dict(sums, orient="index", columns=["attempts", *KINDS])
    table["failed"] = table[list(KINDS)].sum(axis="columns")
    shares = table[list(KINDS)].div(table["attempts"], axis=0)
    table = table.assign(failed_share=table["failed"] / table["attempts"], **shares)
    return table.reset_index(names="place")


_MOST = 25
_TITLE = "Failures"
_NAMES = {name: name.replace("_", " ") for name in OUTCOMES}
_KIND_TEXT = {
    "no return": "did not return",
    "no path": "returned without a path",
    "misses": "brought a path that misses the target",
    "longer": "brought a longer path",
}


def failures_section(results: Results | None) -> Section:
    """Outcomes by solver, messages with commands, and where; results are None of an empty run."""
    untaken = "" if results is None else _untaken_text(results.attempts.untaken())
    if results is None or not results.attempts.count:
        lead = "No attempt was recorded, so nothing is known to have failed."
        return Section("failures", _TITLE, untaken, (), lead)
    attempts = results.attempts
    stopped = unreturned(counts.outcomes(attempts))
    frame = counts.regions(attempts)
    kinds = frame[list(KINDS)].sum()
    asked, failed = int(frame["attempts"].sum()), int(kinds.sum())
    limits = time_limits(results)
    blocks: list[Table] = []
    if len(stopped):
        blocks.append(_outcome_table(with_commands(stopped, limits)))
    if failed:
        messages = failures(counts.failures(attempts)).head(_MOST).reset_index(drop=True)
        blocks.append(_message_table(with_commands(messages, limits)))
        blocks.append(_region_table(by_region(frame)))
    lead = _lead(attempts.count, stopped, failed, int(kinds["no return"]))
    text = sentences(_text(kinds, asked, failed) if blocks else "", untaken)
    return Section("failures", _TITLE, text, tuple(blocks), lead)


def time_limits(results: Results) -> dict[str, float]:
    """Experiment -> the time limit of its first folder that states one (s)."""
    stated = [(run.name, run.manifest.time_limit_s) for run in reversed(results.folders)]
    return {name: limit for name, limit in stated if limit is not None}


def _lead(total: int, stopped: pd.DataFrame, failed: int, silent: int) -> str:
    """What to see: how many attempts did not return, and why; how many others failed."""
    lost = int(stopped["unreturned"].sum())
    others = f"what solvers said in {some(failed - silent, 'other failure' if lost else 'failure')}"
    if lost:
        sums = stopped[list(OUTCOMES)].sum()
        why = ", ".join(f"{count(n)} {_NAMES[str(name)]}" for name, n in sums.items() if n)
        return (
            f"See which solvers returned no answer in {count(lost)} of {some(total, 'attempt')} "
            f"({why}){f', and {others}' if failed > silent else ''}."
        )
    every = "the only attempt" if total == 1 else f"each of the {count(total)} attempts"
    if failed:
        return f"See {others}, and where their targets lie; {every} returned."
    return f"Nothing failed: {every} returned, and the check accepts every path that was asked for."


def _text(kinds: pd.Series[int], asked: int, failed: int) -> str:
    parts = [f"{count(n)} {_KIND_TEXT[str(kind)]}" for kind, n in kinds.items() if n]
    return sentences(
        f"Of {some(asked, 'attempt')} at questions that have a path, {count(failed)} failed "
        f"({share(failed / asked)}): {', '.join(parts)}."
        if failed
        else f"No attempt at a question that has a path failed ({count(asked)} attempts).",
        "The sections above count each of them in their shares. A longer path is often the local "
        "optimum that a local solver promises; the section on success says how much longer."
        if kinds["longer"]
        else "",
        "An attempt that found none where no path exists has not failed.",
    )


def _untaken_text(untaken: pd.DataFrame) -> str:
    """How many questions solvers do not take, which are no attempts."""
    if untaken.empty:
        return ""
    return (
        f"{some(int(untaken['questions'].sum()), 'more question')} met a solver that does not take "
        f"them (unsupported), most often {untaken['solver'].iloc[0]}: it was not called, and no "
        "share counts them."
    )


def _outcome_table(stopped: pd.DataFrame) -> Table:
    present = {name: title for name, title in _NAMES.items() if stopped[name].any()}
    caption = (
        "Attempts whose process did not return an answer, by solver, at all questions. Timeout: "
        "stopped at the time limit, because the solver did not stop by itself. Unavailable: the "
        "solver is not installed, or has no licence. "
        "Solvers of which every attempt returned are left out. The command repeats one such "
        f"attempt, that of the nearest target, under the time limit of its run.{_cold(stopped)}"
    )
    shown = (
        SOLVER,
        *columns(count, attempts="attempts"),
        *columns(count, **present),
        *columns(count, unreturned="in all"),
        *columns(kind="command", command="ask again"),
    )
    bad = marks(stopped, *present)
    return Table("outcomes", caption, stopped, shown, bad)


def _cold(table: pd.DataFrame) -> str:
    """A sentence on commands that cannot start where their attempt started."""
    warm = table["warm"].eq(True).any()
    return " It starts cold, also where all attempts of its line started warm." if warm else ""


def _message_table(table: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(kind="text", outcome="outcome", claim="claim", verdict="verdict"),
        *columns(kind="prose", message="what the solver said"),
        *columns(count, attempts="attempts"),
        *columns(kind="command", command="ask again"),
    )
    caption = (
        "Failures by what was said of them (# stands for a number), "
        f"{f'the {_MOST} most frequent' if len(table) == _MOST else 'the most frequent first'}. "
        "The command repeats one of them, that of the nearest target, under the time limit of its "
        f"run.{_cold(table)}"
    )
    return Table("failures", caption, table, shown, numbers=("experiment",), dense=True)


def _region_table(regions: pd.DataFrame) -> Table:
    present = {kind: kind for kind in KINDS if regions[kind].any()}
    shown = (
        *columns(kind="text", place="the target lies"),
        *columns(count, attempts="attempts", failed="failed"),
        *columns(share, failed_share="share"),
        *columns(share, **present),
    )
    caption = (
        "Failures by where the target lies, as numbers and as shares of the attempts there: in "
        "all, and by kind. All solvers together: the numbers say where questions are hard, not "
        "which solver to choose."
    )
    return Table("failures-by-region", caption, regions, shown)


TOPIC = Topic("failures", failures_section, General.POOLED)
