"""The section on success: verdicts, gaps, and what failed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import pandas as pd

from dubins_study.report.data.attempts import Attempts
from dubins_study.report.data.results import Folder, Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    share,
    slug,
)
from dubins_study.report.elements.looks import Palette, legend_lines, name_of
from dubins_study.report.elements.style import HALF, WIDE, new_figure
from dubins_study.report.elements.verdict_table import marks_of_failures, verdict_columns
from dubins_study.report.topics.success.figures import plot_gap_profile, plot_verdicts
from dubins_study.report.topics.success.numbers import failures, gap_quantiles, gap_shares
from dubins_study.report.topics.summary.numbers import summary

_MOST_FAILURES = 25


def success_section(results: Results) -> Section | None:
    """Verdicts, gap profiles, gap quantiles per region, and what failed."""
    attempts = results.attempts
    each = {name: attempts.only({name}) for name in attempts.experiments}
    blocks: list[Picture | Table] = [_verdict_picture(attempts)]
    if len(each) > 1:
        blocks.append(_experiment_table(each))
    quantiles = gap_quantiles(attempts.gap_quantiles())
    if len(quantiles):
        palette = Palette.of(results.solvers)
        allowed = _gap_tolerances(results.folders)
        blocks += [
            _profile_picture(name, own, allowed.get(name), palette) for name, own in each.items()
        ]
        blocks.append(_quantile_table(quantiles, attempts.precision))
    without_success = failures(attempts.failures())
    if len(without_success):
        blocks.append(_failure_table(without_success))
    text = (
        "Every attempt counts, whatever became of it. The gap is (length − reference) / "
        "max(reference, R) and only a path that arrives has one; the others count as "
        "infinitely far off."
    )
    return Section("success", "Success and gaps", text, tuple(blocks))


def _experiment_table(each: Mapping[str, Attempts]) -> Table:
    parts = [summary(own.verdicts()).assign(experiment=name) for name, own in each.items()]
    frame = pd.concat(parts, ignore_index=True)
    left_out = ("optimal", "none exists", "not_returned")  # the rest says it, and fits
    kept = [column for column in verdict_columns() if column.key not in left_out]
    columns = (Column("experiment", "experiment", kind="code"), *kept)
    caption = "The same counts experiment by experiment: each was put to other solvers."
    return Table("summary-by-experiment", caption, frame, columns, marks_of_failures(frame))


def _verdict_picture(attempts: Attempts) -> Picture:
    frame = summary(attempts.verdicts())
    lines = max(name_of(solver).count("\n") + 1 for solver in frame["solver"])
    figure = new_figure(WIDE, 0.9 + max(0.42, 0.14 * lines) * len(frame))
    plot_verdicts(figure.add_subplot(), frame)
    caption = (
        "Verdicts as shares of all attempts. Plain bars are successes, hatched ones are not; false "
        "claims and wrong basins are counted at the right."
    )
    return Picture("verdicts", caption, figure, "Stacked bars of verdicts, one a solver")


def _gap_tolerances(folders: Iterable[Folder]) -> dict[str, float]:
    """The gap that each experiment's runs call optimal; left out where two runs differ."""
    tolerances: dict[str, set[float]] = {}
    for folder in folders:
        tolerances.setdefault(folder.name, set()).add(folder.manifest.gap_tolerance)
    return {name: gap for name, (gap, *others) in tolerances.items() if not others}


def _profile_picture(
    experiment: str, attempts: Attempts, tolerance: float | None, palette: Palette
) -> Picture:
    shares = gap_shares(attempts.gap_profile())
    figure = new_figure(HALF, 3.0 + 0.17 * legend_lines(list(shares), width=40))
    ax = figure.add_subplot()
    plot_gap_profile(ax, shares, palette, tolerance)
    figure.legend(loc="outside lower left", ncols=1, fontsize=7.5)
    caption = (
        f"Experiment {experiment}: share of attempts within each gap. Higher is more reliable, "
        "further left more accurate; a curve that ends below 100 % belongs to a solver that "
        "sometimes does not arrive."
    )
    alt = f"Share of attempts against gap, {experiment}"
    return Picture(f"gap-profile-{slug(experiment)}", caption, figure, alt, True)


def _quantile_table(frame: pd.DataFrame, precision: str) -> Table:
    gap = digits(3)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("region", "target lies", kind="text"),
        Column("attempts", "attempts", count),
        Column("arrived", "arrive", share),
        Column("q50", "median gap", gap),
        Column("q90", "90 %", gap),
        Column("q99", "99 %", gap),
        Column("q100", "worst", gap),
    )
    caption = (
        "Gap quantiles (relative, no unit) by where the target lies. ∞ means that so large a share "
        "of the attempts did not arrive that the quantile is not reached."
        f"{precision}"
    )
    return Table("gap-quantiles", caption, frame, columns)


def _failure_table(failures_by_kind: pd.DataFrame) -> Table:
    frame = failures_by_kind.head(_MOST_FAILURES).reset_index(drop=True)
    columns = (
        Column("solver", "solver", kind="code"),
        Column("outcome", "outcome", kind="text"),
        Column("claim", "claim", kind="text"),
        Column("verdict", "verdict", kind="text"),
        Column("said", "the backend said", kind="prose"),
        Column("attempts", "attempts", count),
    )
    caption = (
        "Attempts without success by what was said of them (# stands for a number), the "
        f"{_MOST_FAILURES} most frequent."
    )
    return Table("failures", caption, frame, columns)
