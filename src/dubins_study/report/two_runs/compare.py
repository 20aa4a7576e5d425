"""`compare`: two runs, solver by solver, with what became worse and a page of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

from dubins_study.errors import DubinsStudyError
from dubins_study.report.data.results import Folder, load
from dubins_study.report.page.render import Head, write_page
from dubins_study.report.two_runs.changes import (
    pairs,
    solver_changes,
    time_ratios,
    unanswered,
    unpaired,
)
from dubins_study.report.two_runs.circumstances import differences, machine_speed, unchanged_solvers
from dubins_study.report.two_runs.comparison import Comparison, regressions
from dubins_study.report.two_runs.section import sections

SLOWER = 1.1


class CompareError(DubinsStudyError, ValueError):
    """Two runs cannot be compared."""


def compare(
    base: str | FilePath,
    new: str | FilePath,
    out: str | FilePath | None = None,
    slower: float = SLOWER,
) -> Comparison:
    """Compare two results folders of one experiment, question by question.

    Args:
        base: the folder to compare with.
        new: the folder that may have become better or worse.
        out: the folder to write a page to, with tables and figures; None: no page.
        slower: a solver is slower if its time, the machine's speed taken out, is surely more than
            so many times the base's.

    Raises:
        ResultsError: if a folder cannot be read.
        CompareError: if no solver was asked the same question in both, or `slower` is below 1.
        ReportError: if `out` cannot be written.
    """
    if not slower >= 1:
        raise CompareError(f"slower is {slower!r}: expected a ratio of at least 1, e.g. {SLOWER}")
    before, after = load([base]), load([new])
    paired = pairs(before, after)
    if paired.empty:
        raise CompareError(
            f"{base} and {new} share no question of one solver; expected two runs of one "
            "experiment, or of experiments that overlap"
        )
    unchanged = unchanged_solvers(before, after)
    speed = machine_speed(before, after, time_ratios(paired), unchanged)
    changes = solver_changes(paired, speed, unchanged)
    comparison = Comparison(
        changes,
        regressions(paired, changes, unanswered(after), slower),
        unpaired(before, after),
        differences(before, after),
        speed,
        slower,
    )
    if out is None:
        return comparison
    folders = (*before.folders, *after.folders)
    was, is_now = _described(FilePath(base), folders[0]), _described(FilePath(new), folders[1])
    asked = f"What became better or worse in the new run, {is_now}, than in the base, {was}?"
    head = Head("Two runs compared", asked)
    page = write_page(out, lambda: sections(paired, comparison), folders, head)
    return replace(comparison, page=page)


def _described(place: FilePath, folder: Folder) -> str:
    manifest = folder.manifest
    commit = str(manifest.git.get("commit") or "")[:10]
    parts = [f"experiment {folder.name}", manifest.created or "", commit and f"commit {commit}"]
    return f"{place.name or place} ({', '.join(filter(None, parts))})"
