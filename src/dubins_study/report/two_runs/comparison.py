"""The result of a comparison of two runs.

It has regressions, a verdict for each solver, and other differences of the runs.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import pandas as pd

from dubins_study.report.data.attempts import Mask
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

ALPHA = 0.05  # the level of the test of shares right, as on the page
_FEWEST_TIMED = 6  # questions; with fewer no test can reach this level


@dataclass(frozen=True, eq=False)
class Comparison:
    """The result of a comparison of two runs.

    Args:
        solvers: one row per solver: verdict (what is worse, else what is better), and the columns
            of `report.two_runs.changes.solver_changes`.
        regressions: what became worse: kind (`no longer right`, `no longer denied`, `false claim`,
            `less accurate`, `right less often`, `slower`, `not answered`), solver, scenario (its
            label, or its target), branch, base and new (as text), and the command that asks the
            question again. The last three kinds concern all questions of a solver, so they have no
            branch and no command.
        unpaired: solver, and how many questions only one of the runs was asked.
        differences: what, base, new: in what else the runs differ, apart from the code of solvers.
        speed: times of the new run's machine divided by those of the base's; None if unknown.
        slower: a solver is slower if its time ratio is surely above this number.
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
    """The solvers with fewer rows than cells.

    Columns solver, cells (those of the plan), rows (those in the folder). The run is not finished,
    or it lost rows.
    """
    there = pd.concat([results.rows["solver"], results.untaken["solver"]]).value_counts()
    cells = {spec: entry.cells for spec, entry in results.folders[0].manifest.solvers.items()}
    frame = pd.DataFrame({"cells": pd.Series(cells, dtype=int), "rows": there})
    frame = frame.fillna(0).astype(int).rename_axis("solver").reset_index()
    return frame[frame["rows"] < frame["cells"]]


def regressions(
    pairs: pd.DataFrame, changes: pd.DataFrame, unanswered: pd.DataFrame, slower: float
) -> pd.DataFrame:
    """What became worse, in the order of kinds.

    The columns are those of `Comparison.regressions`. `unanswered` has the solvers of the new run
    that lack rows. `slower` is infinite where the machine's speed is not known; then no solver is
    called slower.
    """
    was_lost = lost(pairs)
    # `lost` needs all repeats to change. This test of shares sees fewer right repeats too.
    less_often = _share_changed(changes) & (changes["right_new"] < changes["right_base"])
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


def _share_changed(changes: pd.DataFrame) -> Mask:
    """A mask of solvers whose share right changed.

    The sign test's p is below the level `ALPHA`.
    """
    return changes["right_p"].lt(ALPHA)


def _timed(changes: pd.DataFrame) -> Mask:
    """A mask of solvers with comparable times.

    Their code changed, and enough of their questions have times. The times of unchanged solvers
    differ by the machine only.
    """
    return ~changes["same_code"] & changes["timed"].ge(_FEWEST_TIMED)


def verdicts(changes: pd.DataFrame, regressions: pd.DataFrame, slower: float) -> list[str]:
    """A verdict for each solver, as text.

    The text says what is worse. If nothing is, it says what is better, by the same tests in the
    other direction. Else it is `same code` or `no change`.
    """
    more_often = _share_changed(changes) & (changes["right_new"] > changes["right_base"])
    faster = _timed(changes) & changes["time_ratio_high"].lt(1 / slower)
    texts = []
    for row in changes.assign(more_often=more_often, faster=faster).to_dict("records"):
        worse = regressions.loc[regressions["solver"] == row["solver"], "kind"].unique()
        better = []
        if row["gained"] > 0:  # single questions; `more_often` is a significant share of all
            better.append(f"{row['gained']} more right")
        if row["more_often"]:
            better.append("right more often")
        if row["faster"]:
            better.append("faster")
        if len(worse):
            texts.append(f"worse: {', '.join(worse)}")
        elif better:
            texts.append(f"better: {', '.join(better)}")
        elif row["same_code"]:
            texts.append("same code")
        else:
            texts.append("no change")
    return texts


def _right(value: float) -> str:
    return f"right in {share(value)} of the repeats"


def _false(value: bool) -> str:
    if value:
        return "a false claim"
    return "none"


def _gap(value: float) -> str:
    if value != value:
        return "no path that arrives"
    return f"gap {digits(2)(value)}"


_Record = Mapping[Hashable, Any]


def _questions(
    kind: str, rows: pd.DataFrame, column: str, show: Callable[[Any], str]
) -> Iterator[_Record]:
    """Yield a line of the regressions for each question.

    `show` turns the values of `column`_base and `column`_new into texts.
    """
    for row in rows.to_dict("records"):
        place = f"target {row['target_x']:.6g}, {row['target_y']:.6g}"
        if is_missing(row["target_x"]):
            place = "no target"
        if row["label"]:
            place = f"{row['label']}: {place}"
        yield {
            "kind": kind,
            "solver": row["solver"],
            "scenario": place,
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
    """The facts in which two manifests differ.

    Columns what, base, new (as text; a dash where a manifest does not have the fact).
    """
    facts = pd.DataFrame({"base": _facts(base), "new": _facts(new)}, dtype=object)
    texts = facts.replace("", None).fillna(ABSENT).astype(str)
    return texts[texts["base"] != texts["new"]].rename_axis("what").reset_index()


def _facts(manifest: Manifest) -> pd.Series[Any]:
    """The facts of a manifest, by name."""
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
