"""How often solvers are right where a path exists, and how exact their paths are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Folder, Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import (
    General,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, sentences, share, slug, some
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import Palette, in_page_order
from dubins_study.report.elements.plots import DRAWN_TEXT, share_curves
from dubins_study.report.statistics.methods import (
    MOST_ENGINES,
    MOST_METHODS,
    drawn_methods,
    foremost,
)
from dubins_study.report.statistics.metrics import by_solver, gaps, upper_quantile
from dubins_study.report.topics.summary import best_solvers, solver_summary, summary_table
from dubins_study.study.closed_form.shortest import REGIONS

ALL_REGIONS = ("all", *REGIONS)
QUANTILES = (
    SOLVER,
    *columns(kind="text", region="target lies"),
    *columns(count, attempts="attempts"),
    *columns(share, arrived="arrive"),
    *columns(digits(3), q50="median gap", q90="90 %", q99="99 %", q100="worst"),
)
_SHARES = (0.5, 0.9, 0.99, 1.0)
_GAPS = np.geomspace(1e-16, 10.0, 171)  # points of a curve, ten to a decade


def gap_quantiles(attempts: pd.DataFrame) -> pd.DataFrame:
    """Gap quantiles for questions that have an answer: one row per solver and region.

    The region `all` joins all regions; one that holds all of a solver's attempts is left out. The
    gap of an attempt that does not arrive counts as infinite.

    Columns: solver, region, attempts, arrived (a share of them), and q50, q90, q99, q100.
    """
    asked = attempts.loc[attempts["answerable"], ["solver", "region"]].assign(gap=gaps(attempts))
    each = asked[asked["region"].isin(ALL_REGIONS)]
    groups = pd.concat([asked.assign(region="all"), each]).groupby(["solver", "region"])["gap"]
    lines = [
        (*key, len(part), np.isfinite(part).mean(), *(upper_quantile(part, q) for q in _SHARES))
        for key, part in groups
    ]
    names = ["solver", "region", "attempts", "arrived", *(f"q{100 * q:g}" for q in _SHARES)]
    frame = pd.DataFrame(lines, columns=names)
    every = frame.groupby("solver")["attempts"].transform("max")
    news = frame[(frame["region"] == "all") | (frame["attempts"] < every)]
    return by_solver(news.sort_values("region", key=lambda region: region.map(ALL_REGIONS.index)))


def gap_shares(attempts: pd.DataFrame) -> pd.DataFrame:
    """Shares of the attempts at questions with an answer, indexed by gap; a column per solver."""
    ends = _GAPS * (1 + 1e-12)  # but for the rounding of the gaps
    groups = gaps(attempts).groupby(attempts["solver"])
    shares = {str(s): np.searchsorted(np.sort(g), ends, "right") / len(g) for s, g in groups}
    return pd.DataFrame(shares, pd.Index(_GAPS, name="gap"))


def success_section(results: Results) -> Section | None:
    """Gap profiles, and gap quantiles per region."""
    each = {
        name: results.only({name}).attempts
        for name in sorted({run.name for run in results.folders})
    }
    quantiles = gap_quantiles(results.attempts)
    if quantiles.empty:
        return None
    allowed, palette = _gap_tolerances(results.folders), Palette.of_page(results)
    blocks: list[Picture | Table] = [
        _profile_picture(name, one, allowed.get(name), palette) for name, one in each.items()
    ]
    if len(each) > 1:
        blocks.append(_experiment_table(each))
    table = _quantile_table(in_page_order(quantiles, results))
    blocks += best_first(table, table.frame["solver"], best_solvers(results))
    text = (
        "Questions that have a path; every attempt at them counts, failed ones too. The gap is "
        "(length − reference) / max(reference, R) and only a path that arrives has one; the others "
        "count as infinitely far off."
    )
    lead = "See how exact the paths of each method are where it arrives, and how often it does."
    return Section("success", "Success and gaps", text, tuple(blocks), lead)


def _experiment_table(each: Mapping[str, pd.DataFrame]) -> Table:
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


def _gap_tolerances(folders: Iterable[Folder]) -> dict[str, float]:
    """Experiment -> largest gap that its runs accept as optimal; left out if two runs differ."""
    tolerances: dict[str, set[float]] = {}
    for folder in folders:
        tolerances.setdefault(folder.name, set()).add(folder.manifest.gap_tolerance)
    return {name: gap for name, (gap, *others) in tolerances.items() if not others}


def _profile_picture(
    experiment: str, attempts: pd.DataFrame, tolerance: float | None, palette: Palette
) -> Picture:
    shares = gap_shares(attempts)
    caption = (
        f"Experiment {experiment}: share of attempts within each gap. Higher is more reliable, "
        "further left more accurate; a curve that ends below 100 % belongs to a solver that "
        "sometimes does not arrive."
    )
    if len(shares.columns) > MOST_METHODS:
        methods = solver_summary(attempts)
        drawn = drawn_methods(methods[methods["solver"].isin(shares.columns)])
        groups = drawn.groupby("formulation", sort=False)["solver"]
        panels = {str(title): shares[list(solvers)] for title, solvers in groups}
        names = dict(zip(drawn["solver"], drawn["short"], strict=True))
        rest = f"{DRAWN_TEXT} Grey: behind the first of a panel."
    else:
        named = foremost(
            shares.iloc[-1] if tolerance is None else shares[: 1.01 * tolerance].iloc[-1]
        )
        panels, names = {"": shares}, {solver: palette.label(solver) for solver in named}
        grey = len(shares.columns) - MOST_ENGINES
        rest = f"Grey, without names: {some(grey, 'solver')}, optimal least often."
        rest = rest if grey > 0 else ""
    limit = "" if tolerance is None else "Dotted: optimal up to here."
    data = panels, names, palette, "gap to the shortest length (relative)", "share of all attempts"
    name, alt = f"gap-profile-{slug(experiment)}", f"Share of attempts against gap, {experiment}"
    caption = sentences(caption, limit, rest)
    return panels_picture(name, caption, share_curves, alt, *data, limit=tolerance)


def _quantile_table(frame: pd.DataFrame) -> Table:
    several = frame["solver"].nunique() > MOST_METHODS
    if several:  # else the table has some hundred lines
        frame = frame[frame["region"] == "all"].reset_index(drop=True)
    caption = (
        "Gap quantiles (relative, no unit) by where the target lies. ∞ means that so large a share "
        "of the attempts did not arrive that the quantile is not reached."
        f"{' Of so many solvers only all regions together.' if several else ''}"
    )
    return Table("gap-quantiles", caption, frame, QUANTILES)


TOPIC = Topic("success and gaps", success_section, General.POOLED)
