"""What a comparison of two runs says: what is worse, a verdict for each solver, what differs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.formats import ABSENT, digits, seconds, share
from dubins_study.report.two_runs.changes import (
    TIME_RATIO,
    MachineSpeed,
    less_accurate,
    lost,
    newly_false,
)
from dubins_study.study.rows.manifest import Manifest
from dubins_study.study.scenario_frame import is_missing, solve_command

ALPHA = 0.05  # a change of the share of right answers is as sure as the tests of the page
_FEWEST_TIMED = 6  # questions: fewer times, all longer, are no sign at this level


@dataclass(frozen=True, eq=False)
class Comparison:
    """What two runs have in common, and what changed.

    Args:
        solvers: one row per solver: verdict (what is worse, else what is better), and the columns
            of `report.two_runs.changes.solver_changes`.
        regressions: what became worse: kind (`no longer right`, `no longer denied`, `false claim`,
            `less accurate`, `right less often`, `slower`, `not answered`), solver, scenario (its
            label, or its target), branch, base and new (as text), and the command that asks the
            question again. The last three kinds are of all questions of a solver: without scenario.
        unpaired: solver, and how many questions only one of the runs was asked.
        differences: what, base, new: what else the runs differ in, but for the code of solvers.
        speed: of the new run's machine by the base's; None if nothing says it.
        slower: how many times as long counts as slower.
        page: the page that was written; None if none was asked for.
    """

    solvers: pd.DataFrame
    regressions: pd.DataFrame
    unpaired: pd.DataFrame
    differences: pd.DataFrame
    speed: MachineSpeed | None
    slower: float
    page: FilePath | None = None

    @property
    def regressed(self) -> bool:
        """Whether anything became worse."""
        return not self.regressions.empty


def unanswered(results: Results) -> pd.DataFrame:
    """solver, cells (asked), rows (there) where a run is not finished, or lost rows."""
    there = pd.concat([results.rows["solver"], results.untaken["solver"]]).value_counts()
    asked = {spec: entry.cells for spec, entry in results.folders[0].manifest.solvers.items()}
    frame = pd.DataFrame({"cells": pd.Series(asked, dtype=int), "rows": there})
    frame = frame.fillna(0).astype(int).rename_axis("solver").reset_index()
    return frame[frame["rows"] < frame["cells"]]


def regressions(
    pairs: pd.DataFrame, changes: pd.DataFrame, unanswered: pd.DataFrame, slower: float
) -> pd.DataFrame:
    """What became worse, in the order of the kinds; of the new run the cells without an answer.

    `slower` is infinite where the machine's speed is not known: then no solver is called slower.
    """
    was_lost = lost(pairs)
    # Seen in repeats too: a question that is right in one of three was right in all.
    less_often = _surely_changed(changes) & (changes["right_new"] < changes["right_base"])
    took_longer = _timed(changes) & changes["time_ratio_low"].gt(slower)
    lines = [
        *_questions("no longer right", pairs[was_lost & pairs["answerable"]], "right", _right),
        *_questions("no longer denied", pairs[was_lost & ~pairs["answerable"]], "right", _right),
        *_questions("false claim", pairs[newly_false(pairs)], "false", _false),
        *_questions("less accurate", pairs[less_accurate(pairs)], "gap", _gap),
        *map(_less_often, changes[less_often].to_dict("records")),
        *map(_slower, changes[took_longer].to_dict("records")),
        *map(_not_answered, unanswered.to_dict("records")),
    ]
    columns = ["kind", "solver", "scenario", "branch", "base", "new", "command"]
    return pd.DataFrame(lines, columns=columns, dtype=object).fillna("")


def _surely_changed(changes: pd.DataFrame) -> pd.Series[bool]:
    """Whether the share of right answers of each solver is another one."""
    return changes["right_p"].lt(ALPHA)


def _timed(changes: pd.DataFrame) -> pd.Series[bool]:
    """Whether the times of each solver say something of it: its code changed, on enough questions.

    Times of the same code are the machine's.
    """
    return ~changes["same_code"] & changes["timed"].ge(_FEWEST_TIMED)


def verdicts(changes: pd.DataFrame, regressions: pd.DataFrame, slower: float) -> list[str]:
    """What is worse of each solver, else what is better, by the mirror images of the tests."""
    more_often = _surely_changed(changes) & (changes["right_new"] > changes["right_base"])
    faster = _timed(changes) & changes["time_ratio_high"].lt(1 / slower)
    texts = []
    for row in changes.assign(more_often=more_often, faster=faster).to_dict("records"):
        worse = regressions.loc[regressions["solver"] == row["solver"], "kind"].unique()
        better = {
            f"{row['gained']} more right": row["gained"] > 0,
            "right more often": row["more_often"],
            "faster": row["faster"],
        }
        applying = [text for text, applies in better.items() if applies]
        if len(worse):
            texts.append(f"worse: {', '.join(worse)}")
        elif applying:
            texts.append(f"better: {', '.join(applying)}")
        else:
            texts.append("same code" if row["same_code"] else "no change")
    return texts


def _right(value: float) -> str:
    return f"right in {share(value)} of the repeats"


def _false(value: bool) -> str:
    return "a false claim" if value else "none"


def _gap(value: float) -> str:
    return f"gap {digits(2)(value)}" if value == value else "no path that arrives"


_Record = Mapping[Hashable, Any]


def _questions(
    kind: str, rows: pd.DataFrame, column: str, show: Callable[[Any], str]
) -> Iterator[_Record]:
    """A line for each question, with what both runs have in a column."""
    for row in rows.to_dict("records"):
        place = f"target {row['target_x']:.6g}, {row['target_y']:.6g}"
        if is_missing(row["target_x"]):
            place = "no target"
        yield {
            "kind": kind,
            "solver": row["solver"],
            "scenario": f"{row['label']}: {place}" if row["label"] else place,
            "branch": row["branch"],
            "base": show(row[f"{column}_base"]),
            "new": show(row[f"{column}_new"]),
            "command": solve_command(row),
        }


def _less_often(row: _Record) -> _Record:
    return {
        "kind": "right less often",
        "solver": row["solver"],
        "scenario": f"all {row['questions']} questions with a path",
        "base": f"right in {share(row['right_base'])}",
        "new": f"right in {share(row['right_new'])}",
    }


def _slower(row: _Record) -> _Record:
    ratio, low, high = (digits(3)(row[key]) for key in TIME_RATIO)
    return {
        "kind": "slower",
        "solver": row["solver"],
        "scenario": f"mean of {row['timed']} questions",
        "base": seconds(row["time_base"]),
        "new": f"{ratio} times as long ({low} to {high})",
    }


def _not_answered(row: _Record) -> _Record:
    answered = f"{row['rows']} of the {row['cells']} cells asked"
    return {"kind": "not answered", "solver": row["solver"], "new": answered}


def differences(base: Manifest, new: Manifest) -> pd.DataFrame:
    """What the runs of two manifests do not share: what, base, new (as text)."""
    facts = pd.DataFrame({"base": _facts(base), "new": _facts(new)}, dtype=object)
    texts = facts.replace("", None).fillna(ABSENT).astype(str)
    return texts[texts["base"] != texts["new"]].rename_axis("what").reset_index()


def _facts(manifest: Manifest) -> pd.Series[Any]:
    """What a manifest says of its run."""
    plain = ("profile", "time_limit_s", "memory_limit_gib", "gap_tolerance")
    jobs = sorted({str(run.jobs) for run in manifest.runs})
    facts = {
        **{name.replace("_", " "): getattr(manifest, name) for name in plain},
        **{f"machine: {key}": value for key, value in manifest.machine.items()},
        **{f"version of {key}": value for key, value in manifest.versions.items()},
        "git commit": manifest.git.get("commit"),
        "jobs": ", ".join(jobs),
    }
    return pd.Series(facts, dtype=object)
