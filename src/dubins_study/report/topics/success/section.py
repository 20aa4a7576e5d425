"""The section on success: verdicts and gaps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import pandas as pd

from dubins_study.report.data.attempts import Attempts
from dubins_study.report.data.results import Folder, Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, sentences, share, slug, some
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.names import in_page_order
from dubins_study.report.elements.plots import DRAWN_TEXT, HIGHEST
from dubins_study.report.elements.style import WIDE
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import MOST_ENGINES, MOST_METHODS, drawn_methods
from dubins_study.report.topics.success.figures import (
    plot_gap_profile,
    plot_gap_profiles,
    plot_verdict_grid,
    plot_verdicts,
)
from dubins_study.report.topics.success.numbers import gap_quantiles, gap_shares
from dubins_study.report.topics.summary.section import best_solvers, solver_summary, summary_table


def success_section(results: Results) -> Section | None:
    """Verdicts, gap profiles and gap quantiles per region."""
    attempts = results.attempts
    each = {name: attempts.only({name}) for name in attempts.experiments}
    frame = solver_summary(attempts)
    frame = frame[frame["attempts"] > 0]
    palette = Palette.of_page(results)
    blocks: list[Picture | Table] = [_verdict_picture(frame, palette)] if len(frame) else []
    if len(each) > 1:
        blocks.append(_experiment_table(each))
    quantiles = gap_quantiles(attempts.gap_quantiles())
    if len(quantiles):
        allowed = _gap_tolerances(results.folders)
        blocks += [
            _profile_picture(name, one, allowed.get(name), palette) for name, one in each.items()
        ]
        ordered = in_page_order(quantiles, results)
        table = _quantile_table(ordered)
        blocks += best_first(table, table.frame["solver"], best_solvers(results))
    text = (
        "Questions that have a path; every attempt at them counts, failed ones too. The gap is "
        "(length − reference) / max(reference, R) and only a path that arrives has one; the others "
        "count as infinitely far off."
    )
    lead = (
        "See in the bars how often each method is right, and in the curves how exact its paths are "
        "where it arrives."
    )
    return Section("success", "Success and gaps", text, tuple(blocks), lead) if blocks else None


def _experiment_table(each: Mapping[str, Attempts]) -> Table:
    parts = [solver_summary(one).assign(experiment=name) for name, one in each.items()]
    frame = pd.concat(parts, ignore_index=True)
    caption = (
        "The summary's numbers per experiment: not all experiments ask the same solvers. Questions "
        "that have a path."
    )
    return summary_table(
        "summary-by-experiment",
        caption,
        frame[frame["attempts"] > 0].reset_index(drop=True),
        columns(kind="code", experiment="experiment"),
    )


def _verdict_picture(frame: pd.DataFrame, palette: Palette) -> Picture:
    what = (
        "Verdicts as shares of all attempts at questions that have a path. The plain "
        "blue is success, hatched and grey are not"
    )
    alt = "Stacked bars of verdicts, one per solver"
    if len(frame) > MOST_METHODS:
        figure = plot_verdict_grid(drawn_methods(frame))
        return Picture("verdicts", f"{what}. {DRAWN_TEXT}", figure, alt)
    return picture(
        "verdicts",
        plot_verdicts,
        *(frame, palette),
        caption=f"{what}; false claims and wrong basins are counted at the right.",
        alt=alt,
        height=min(HIGHEST, 0.9 + 0.36 * len(frame)),
        width=WIDE,
    )


def _gap_tolerances(folders: Iterable[Folder]) -> dict[str, float]:
    """Experiment -> largest gap that its runs accept as optimal; left out if two runs differ."""
    tolerances: dict[str, set[float]] = {}
    for folder in folders:
        tolerances.setdefault(folder.name, set()).add(folder.manifest.gap_tolerance)
    return {name: gap for name, (gap, *others) in tolerances.items() if not others}


def _profile_picture(
    experiment: str, attempts: Attempts, tolerance: float | None, palette: Palette
) -> Picture:
    shares = gap_shares(attempts.gap_profile())
    name, alt = f"gap-profile-{slug(experiment)}", f"Share of attempts against gap, {experiment}"
    caption = (
        f"Experiment {experiment}: share of attempts within each gap. Higher is more reliable, "
        "further left more accurate; a curve that ends below 100 % belongs to a solver that "
        "sometimes does not arrive."
    )
    limit = "" if tolerance is None else "Dotted: optimal up to here."
    if len(shares) > MOST_METHODS:
        frame = solver_summary(attempts)
        drawn = drawn_methods(frame[frame["solver"].isin(list(shares))])
        figure = plot_gap_profiles(drawn, shares, palette, tolerance)
        return Picture(name, sentences(caption, limit, DRAWN_TEXT), figure, alt)
    grey = len(shares) - MOST_ENGINES
    rest = f"Grey, without names: {some(grey, 'solver')}, optimal least often."
    figure = plot_gap_profile(shares, palette, tolerance)
    return Picture(name, sentences(caption, limit, rest if grey > 0 else ""), figure, alt)


def _quantile_table(frame: pd.DataFrame) -> Table:
    gap = digits(3)
    several = frame["solver"].nunique() > MOST_METHODS
    if several:  # else the table has some hundred lines
        frame = frame[frame["region"] == "all"].reset_index(drop=True)
    shown = (
        SOLVER,
        *columns(kind="text", region="target lies"),
        *columns(count, attempts="attempts"),
        *columns(share, arrived="arrive"),
        *columns(gap, q50="median gap", q90="90 %", q99="99 %", q100="worst"),
    )
    caption = (
        "Gap quantiles (relative, no unit) by where the target lies. ∞ means that so large a share "
        "of the attempts did not arrive that the quantile is not reached."
        f"{' Of so many solvers only all regions together.' if several else ''}"
    )
    return Table("gap-quantiles", caption, frame, shown)


TOPIC = Topic("success and gaps", success_section, General.POOLED, counted=True)
