"""`compare`: two runs, solver by solver, with what became worse, and a page of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pandas as pd

from dubins_study.errors import DubinsStudyError
from dubins_study.report.data.results import Folder, load
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share, some
from dubins_study.report.elements.identity import interval_keys, with_interval, with_interval_texts
from dubins_study.report.elements.style import (
    INK,
    MUTED,
    VERMILION,
    WIDE,
    Style,
    duration,
    log_axis,
    new_figure,
)
from dubins_study.report.page.render import Head, write_page
from dubins_study.report.two_runs.changes import (
    GAP_FLOOR,
    WORSE_GAP,
    machine_speed,
    pairs,
    solver_changes,
    unchanged_solvers,
    unpaired,
)
from dubins_study.report.two_runs.comparison import Comparison, differences, regressions, unanswered

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
    speed = machine_speed(before, after, paired, unchanged)
    changes = solver_changes(paired, speed, unchanged)
    comparison = Comparison(
        changes,
        regressions(paired, changes, unanswered(after), slower),
        unpaired(before, after),
        differences(before.folders[0].manifest, after.folders[0].manifest),
        speed,
        slower,
    )
    if out is None:
        return comparison
    folders = (*before.folders, *after.folders)
    was, is_now = _described(FilePath(base), folders[0]), _described(FilePath(new), folders[1])
    asked = f"What became better or worse in the new run, {is_now}, than in the base, {was}?"
    head = Head("Two runs compared", asked)

    def sections() -> list[Section]:
        return [
            _regressions(comparison),
            _solvers(comparison),
            _times(paired, comparison),
            _else(comparison),
        ]

    return replace(comparison, page=write_page(out, sections, folders, head))


def _described(place: FilePath, folder: Folder) -> str:
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
    frame = comparison.regressions
    kinds = frame["kind"].value_counts(sort=False)
    what = ", ".join(f"{number} {kind}" for kind, number in kinds.items())
    text = (
        f"{some(len(frame), 'regression')}: {what}."
        if len(frame)
        else "Nothing became worse: no right answer was lost, no false claim is new, no answer is "
        "less accurate, and no solver is surely right less often, or slower."
    )
    caption = (
        "No longer right (or denied): in every repeat of the base, in none of the new run. Less "
        f"accurate: a gap {WORSE_GAP:g} times as large, and above {GAP_FLOOR:g}. Right less often, "
        "slower: the interval of the change lies below 0, of the time ratio above "
        f"{comparison.slower:g}, and the test agrees. Not answered: cells without a row."
    )
    blocks = (Table("regressions", caption, frame, _REGRESSIONS),) if len(frame) else ()
    lead = (
        "Each line is a question that the base answered better, with the command that asks it."
        if len(frame)
        else "No line here: no question was answered better by the base."
    )
    return Section("regressions", "What became worse", text, blocks, lead)


def _solvers(comparison: Comparison) -> Section:
    frame = comparison.with_verdicts()
    frame = with_interval_texts(frame, right_change=_points, time_ratio=digits(3))
    success = (
        SOLVER,
        Column("verdict", "verdict", kind="text"),
        *columns(count, questions="questions"),
        *columns(share, right_base="right, base", right_new="right, new"),
        Column("right_change_text", "change, points", kind="cell"),
        *columns(digits(2), right_p="p"),
        *columns(count, lost="lost", gained="gained", false_new="new false claims"),
        *columns(count, denials_lost="no longer denied"),
    )
    accuracy = (
        SOLVER,
        *columns(digits(2), gap_base="largest gap, base", gap_new="largest gap, new"),
        *columns(count, gap_worse="less accurate"),
        *columns(digits(2), gap_p="p of gaps"),
        *columns(count, timed="timed"),
        *columns(seconds, time_base="time, base", time_new="time, new"),
        Column("time_ratio_text", "time ratio", kind="cell"),
        *columns(digits(2), time_p="p of times"),
    )
    bad = marks(frame, "lost", "false_new", "denials_lost", "gap_worse")
    tables = (
        Table(
            "compared",
            "Questions that both runs were asked and that have a path. The change of the share "
            "that is right has its 95 % bootstrap interval over scenarios; p is of the exact sign "
            "test, with Holm's correction over the solvers.",
            frame,
            success,
            bad,
            interval_keys("right_change"),
        ),
        Table(
            "compared-times",
            "Questions that are right in both runs: the largest gap, and geometric means of times; "
            "their ratio is new by base, with its 95 % interval. p: of the sign test of gaps and "
            "of Wilcoxon's test of times, with Holm's correction.",
            frame,
            accuracy,
            bad,
            interval_keys("time_ratio"),
        ),
    )
    text = sentences(f"{some(len(frame), 'solver')} in both runs.", _unpaired(comparison))
    lead = "Read the column verdict first; what is worse is marked."
    return Section("compared", "Solver by solver", text, tables, lead)


def _unpaired(comparison: Comparison) -> str:
    frame = comparison.unpaired
    if frame.empty:
        return "Both were asked the same questions."
    lines = [
        f"only the {side} run was asked {some(number, 'question')} of "
        f"{some(int((frame[key] > 0).sum()), 'solver')}"
        for key, side in (("only_base", "base"), ("only_new", "new"))
        if (number := int(frame[key].sum()))
    ]
    return f"Not compared: {'; '.join(lines)}."


def _points(value: float) -> str:
    text = digits(3)(100 * value)
    return f"+{text}" if value > 0 else text


def _times(pairs: pd.DataFrame, comparison: Comparison) -> Section:
    speed = comparison.speed
    text = (
        "Nothing says how fast the machines were (no solver of the same code, too few calibration "
        "probes): the ratios are as measured, and no solver is called slower."
        if speed is None
        else "The same work took "
        f"{with_interval(digits(3), speed.ratio, speed.low, speed.high)} times as long in the new "
        f"run, by {speed.evidence}. Ratios of solvers whose code changed are divided by that, "
        "their intervals crosswise; those of the same code are as measured: the machine's doing."
    )
    lead = "Dots above the dashed line took longer than the machine explains."
    block = times_picture(pairs, comparison)
    return Section("times", "Times, question by question", text, (block,) if block else (), lead)


def _else(comparison: Comparison) -> Section:
    frame = comparison.differences
    shown = (
        *columns(kind="text", what="what", base="base", new="new"),
        *columns(count, solvers="solvers"),
    )
    caption = "From the manifests; solvers: how many of those in both runs it is about."
    blocks = (Table("differences", caption, frame, shown),) if len(frame) else ()
    text = (
        f"{some(len(frame), 'difference')} in the manifests."
        if len(frame)
        else "The manifests hold the same machine, limits, packages and code."
    )
    lead = "A difference here may explain a change above."
    return Section("differences", "What else differs", text, blocks, lead)


def times_picture(pairs: pd.DataFrame, comparison: Comparison) -> Picture | None:
    """Every question's time in the new run against the base; None if none was timed in both."""
    both = pairs[pairs["time_base"].gt(0) & pairs["time_new"].gt(0)]
    if both.empty:
        return None
    slower = comparison.regressions.query("kind == 'slower'")["solver"]
    caption = (
        "Each dot is a question of one solver: its time in the new run against the base's. "
        "Solid: equally long; dashed: what the machine explains. Triangles: a slower solver."
    )
    figure = new_figure(WIDE, 4.5)
    ax = figure.add_subplot()
    apart = both["solver"].isin(slower)
    looks = ((~apart, MUTED, "o", 0.35), (apart, VERMILION, "^", 0.7))
    for flag, colour, marker, alpha in looks:
        dots: Style = {"c": colour, "marker": marker, "alpha": alpha, "s": 8, "linewidths": 0}
        drawn = both[flag]
        ax.scatter(drawn["time_base"], drawn["time_new"], rasterized=True, **dots)
    times = both[["time_base", "time_new"]].to_numpy()
    ends = np.array([times.min(), times.max()])
    machine = 1.0 if comparison.speed is None else comparison.speed.ratio
    ax.plot(ends, ends, color=INK, linewidth=0.8)
    ax.plot(ends, ends * machine, color=INK, linewidth=0.8, linestyle="--")
    ax.set(xscale="log", yscale="log", xlabel="time in the base", ylabel="time in the new run")
    for axis in (ax.xaxis, ax.yaxis):
        log_axis(axis, duration)
    return Picture("times-pairs", caption, figure, "times of questions in two runs")
