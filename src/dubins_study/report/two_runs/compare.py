"""Compare two runs, and write a page about it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path as FilePath

from dubins_study.errors import DubinsStudyError
from dubins_study.report.data.results import Folder, load
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import Section, Table
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share, some
from dubins_study.report.elements.identity import (
    interval_column,
    interval_keys,
    with_interval,
    with_interval_texts,
)
from dubins_study.report.page.render import Head, write_page
from dubins_study.report.two_runs.changes import (
    GAP_FLOOR,
    SIDES,
    WORSE_GAP,
    MachineSpeed,
    machine_speed,
    pairs,
    solver_changes,
    unpaired,
    without_machine,
)
from dubins_study.report.two_runs.comparison import (
    Comparison,
    differences,
    regressions,
    unanswered,
    verdicts,
)

SLOWER = 1.1


class CompareError(DubinsStudyError, ValueError):
    """Two runs cannot be compared."""


def compare(
    base: str | FilePath,
    new: str | FilePath,
    out: str | FilePath | None = None,
    slower: float = SLOWER,
) -> Comparison:
    """Compare two results folders, question by question.

    Args:
        base: the folder to compare with.
        new: the folder that may have become better or worse.
        out: the folder to write a page to, with tables and figures; None: no page.
        slower: a solver is slower if the interval of its time ratio, without the machine's speed,
            lies above this number.

    Raises:
        ResultsError: if a folder cannot be read.
        CompareError: if no solver was asked the same question in both, or `slower` is below 1.
        ReportError: if `out` cannot be written.
    """
    if not slower >= 1:
        raise CompareError(f"slower is {slower!r}: expected a ratio of at least 1, e.g. {SLOWER}")
    before = load([base])
    after = load([new])
    paired = pairs(before, after)
    if paired.empty:
        raise CompareError(
            f"{base} and {new} share no question of one solver; expected two runs of one "
            "experiment, or of experiments that overlap"
        )
    as_measured = solver_changes(before, after, paired)
    speed = machine_speed(as_measured)
    changes = without_machine(as_measured, speed)
    ratio = slower
    if speed is None:
        ratio = math.inf
    worse = regressions(paired, changes, unanswered(after), ratio)
    changes.insert(1, "verdict", verdicts(changes, worse, ratio))
    comparison = Comparison(
        solvers=changes,
        regressions=worse,
        unpaired=unpaired(before, after, paired),
        differences=differences(before.folders[0].manifest, after.folders[0].manifest),
        speed=speed,
        slower=slower,
    )
    if out is None:
        return comparison
    folders = (*before.folders, *after.folders)
    base_text = _described(FilePath(base), folders[0])
    new_text = _described(FilePath(new), folders[1])
    question = f"What is better or worse in the new run, {new_text}, than in the base, {base_text}?"
    head = Head("Two runs compared", question)

    def sections() -> list[Section]:
        return [_regressions(comparison), _solvers(comparison), _else(comparison)]

    return replace(comparison, page=write_page(out, sections, folders, head))


def _described(place: FilePath, folder: Folder) -> str:
    """A run's folder, experiment, date and commit as text."""
    manifest = folder.manifest
    commit = str(manifest.git.get("commit") or "")[:10]
    parts = [f"experiment {folder.name}", manifest.created or "", commit and f"commit {commit}"]
    return f"{place.name or place} ({', '.join(filter(None, parts))})"


_REGRESSIONS = (
    Column("kind", "what", kind="text"),
    SOLVER,
    *columns(kind="text", scenario="scenario", branch="branch", base="base", new="new"),
    Column("command", "asks it again", kind="code"),
)


def _regressions(comparison: Comparison) -> Section:
    """The section with one line for each regression."""
    frame = comparison.regressions
    text = (
        "Nothing became worse: no right answer was lost, no false claim is new, no answer is less "
        "accurate, and no solver is right less often, or slower, by the tests."
    )
    lead = "No line here: no question was answered better by the base."
    caption = (
        "No longer right (or denied): in every repeat of the base, in none of the new run. Less "
        f"accurate: a gap {WORSE_GAP:g} times as large, and above {GAP_FLOOR:g}. Right less often: "
        "by the exact sign test, with Holm's correction. Slower: the time ratio's interval lies "
        f"above {comparison.slower:g}. Not answered: cells without a row."
    )
    blocks: tuple[Table, ...] = ()
    if len(frame):
        numbers = frame["kind"].value_counts(sort=False)
        kinds = ", ".join(f"{number} {kind}" for kind, number in numbers.items())
        text = f"{some(len(frame), 'regression')}: {kinds}."
        lead = (
            "Each line is a question that the base answered better, with the command that asks it."
        )
        blocks = (Table("regressions", caption, frame, _REGRESSIONS),)
    return Section("regressions", "What became worse", text, blocks, lead)


def solvers_table(comparison: Comparison) -> Table:
    """The table with a line per solver.

    The page shows it, and so does the command.
    """
    shown = (
        SOLVER,
        Column("verdict", "verdict", kind="text"),
        *columns(count, questions="questions"),
        *columns(share, right_base="right, base", right_new="right, new"),
        *columns(count, lost="lost", gained="gained", timed="timed"),
        *columns(seconds, time_base="time, base", time_new="time, new"),
        interval_column("time_ratio", "time, new / base"),
    )
    caption = (
        "Questions that both runs were asked and that have a path. Times are geometric means over "
        "questions right in both; their ratio has its 95 % interval over scenarios."
    )
    frame = with_interval_texts(comparison.solvers, time_ratio=digits(3))
    numbers = interval_keys("time_ratio")
    return Table("compared", caption, frame, shown, marks(frame, "lost"), numbers)


def _solvers(comparison: Comparison) -> Section:
    frame = comparison.solvers
    text = sentences(
        f"{some(len(frame), 'solver')} in both runs.",
        unpaired_text(comparison),
        speed_text(comparison.speed),
    )
    lead = "Read the column verdict first."
    return Section("compared", "Solver by solver", text, (solvers_table(comparison),), lead)


def unpaired_text(comparison: Comparison) -> str:
    """A sentence on questions of one run only."""
    frame = comparison.unpaired
    if frame.empty:
        return "Both were asked the same questions."
    lines = []
    for side in SIDES:
        numbers = frame[f"only_{side}"]
        if numbers.any():
            questions = some(int(numbers.sum()), "question")
            solvers = some(int((numbers > 0).sum()), "solver")
            lines.append(f"only the {side} run was asked {questions} of {solvers}")
    return f"Not compared: {'; '.join(lines)}."


def speed_text(speed: MachineSpeed | None) -> str:
    """The machine's speed, and what it changes, as text."""
    if speed is None:
        return (
            "The speed of the machines is unknown, as no solver has the same code: ratios of times "
            "are as measured, and no solver is called slower."
        )
    interval = with_interval(digits(3), speed.ratio, speed.low, speed.high)
    return (
        f"The same work took {interval} times as long in the new run, by {speed.evidence}. Ratios "
        "of times of solvers whose code changed are divided by this, their intervals crosswise."
    )


def _else(comparison: Comparison) -> Section:
    """The section of all other differences between the runs."""
    frame = comparison.differences
    shown = columns(kind="text", what="what", base="base", new="new")
    caption = "From the manifests of the runs."
    blocks: tuple[Table, ...] = ()
    text = "The manifests have the same machine, limits and packages."
    if len(frame):
        blocks = (Table("differences", caption, frame, shown),)
        text = f"{some(len(frame), 'difference')} in the manifests."
    changed = int((~comparison.solvers["same_code"]).sum())
    text = sentences(text, f"{some(changed, 'solver')} changed in code, settings or packages.")
    lead = "A difference here may explain a change above."
    return Section("differences", "What else differs", text, blocks, lead)
