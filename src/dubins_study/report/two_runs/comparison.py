"""What a comparison of two runs says: what is worse, a verdict for each solver, what differs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.formats import digits, seconds, share
from dubins_study.report.two_runs.changes import (
    ENDS,
    MachineSpeed,
    less_accurate,
    lost,
    newly_false,
)
from dubins_study.study.rows.manifest import Manifest
from dubins_study.study.scenario_frame import solve_command

# A change of times, or of the share of right answers, is as sure as the tests of the page.
ALPHA = 0.05


@dataclass(frozen=True, eq=False)
class Comparison:
    """What two runs have in common, and what changed.

    Args:
        solvers: one row per solver; columns of `report.two_runs.changes.solver_changes`.
        regressions: what became worse: kind (`no longer right`, `no longer denied`, `false claim`,
            `less accurate`, `right less often`, `slower`, `not answered`), solver, scenario (its
            label, or its target), branch, base and new (as text), and the command that asks the
            question again. The last three kinds are of all questions of a solver: without scenario.
        unpaired: solver, and how many questions only one of the runs was asked.
        differences: what, base, new: what else the runs differ in.
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

    def with_verdicts(self) -> pd.DataFrame:
        """`solvers` with a column verdict: what is worse, else what is better."""
        worse = self.regressions.groupby("solver")["kind"].unique()
        verdicts = [
            "worse: " + ", ".join(worse[row["solver"]])
            if row["solver"] in worse.index
            else _better(row, self.slower)
            for _, row in self.solvers.iterrows()
        ]
        return self.solvers.assign(verdict=verdicts)


def unanswered(results: Results) -> pd.DataFrame:
    """solver, cells (asked), rows (there) where a run is not finished, or lost rows."""
    known = results.rows["solver"].value_counts()
    lines = [
        (spec, entry.cells, int(known.get(spec, 0)))
        for spec, entry in results.folders[0].manifest.solvers.items()
        if known.get(spec, 0) < entry.cells
    ]
    return pd.DataFrame(lines, columns=["solver", "cells", "rows"])


def regressions(
    pairs: pd.DataFrame, changes: pd.DataFrame, unanswered: pd.DataFrame, slower: float
) -> pd.DataFrame:
    """What became worse, in the order of the kinds; of the new run the cells without an answer."""
    was_lost = lost(pairs)
    # Seen in repeats too: a question that is right in one of three was right in all.
    less_often = changes["right_change_high"].lt(0) & changes["right_p"].lt(ALPHA)
    # Where the machine's speed is not known, `time_p` is NaN and no solver is called slower.
    took_longer = changes["time_ratio_low"].gt(slower) & changes["time_p"].lt(ALPHA)
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
    empty = dict.fromkeys(columns, "")
    return pd.DataFrame([{**empty, **line} for line in lines], columns=columns)


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
    ratio, low, high = (digits(3)(row[f"time_ratio{end}"]) for end in ENDS)
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


def _better(row: pd.Series, slower: float) -> str:
    """A solver is faster, and right more often, by the mirror images of what makes it worse."""
    better = {
        f"{row['gained']} more right": row["gained"] > 0,
        "right more often": row["right_change_low"] > 0 and row["right_p"] < ALPHA,
        "faster": row["time_ratio_high"] < 1 / slower and row["time_p"] < ALPHA,
    }
    texts = [text for text, applies in better.items() if applies]
    if texts:
        return "better: " + ", ".join(texts)
    return "same code" if row["same_code"] else "no change"


_CODE = "code of solvers, settings or packages"


def differences(base: Manifest, new: Manifest) -> pd.DataFrame:
    """What two manifests do not share: what, base, new (as text), and solvers.

    `solvers` is how many of the solvers in both runs it is about; NaN if it is about the run.
    """
    before = _facts(base, new)
    after = _facts(new, base)
    lines: Counter[tuple[str, str, str]] = Counter()
    for what, solver in dict.fromkeys([*before, *after]):
        old = before.get((what, solver))
        newer = after.get((what, solver))
        if old != newer:
            texts = ("one digest", "another") if what == _CODE else (_text(old), _text(newer))
            lines[what, *texts] += solver is not None
    frame = pd.DataFrame([*lines], columns=["what", "base", "new"])
    solvers = pd.Series([*lines.values()], dtype=float)
    return frame.assign(solvers=solvers.where(solvers > 0))


def _facts(manifest: Manifest, other: Manifest) -> dict[tuple[str, str | None], object]:
    """(what, None) -> what a manifest says of its run; (what, solver) -> of a solver in both."""
    plain = ("profile", "time_limit_s", "memory_limit_gib", "gap_tolerance")
    jobs = sorted({run.jobs for run in manifest.runs})
    of_run: dict[str, object] = {name.replace("_", " "): getattr(manifest, name) for name in plain}
    of_run |= {f"machine: {key}": value for key, value in manifest.machine.items()}
    of_run |= {f"version of {key}": value for key, value in manifest.versions.items()}
    of_run |= {"git commit": manifest.git.get("commit"), "jobs": ", ".join(map(str, jobs))}
    facts: dict[tuple[str, str | None], object] = {(what, None): of_run[what] for what in of_run}
    for solver, entry in manifest.solvers.items():
        if solver in other.solvers:
            packages = entry.packages.items()
            facts |= {(f"package {name}", solver): version for name, version in packages}
            facts[f"settings of {solver}", solver] = entry.settings
            facts[_CODE, solver] = entry.code_digest
    return facts


def _text(value: object) -> str:
    return "–" if value is None or value == "" else str(value)
