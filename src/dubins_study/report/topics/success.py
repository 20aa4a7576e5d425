"""Shares of attempts within each gap, by experiment.

Only questions that have a path count.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    General,
    Picture,
    Section,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import sentences, slug, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import DRAWN_TEXT, share_curves
from dubins_study.report.statistics.methods import (
    MOST_ENGINES,
    MOST_METHODS,
    drawn_methods,
    foremost,
)
from dubins_study.report.statistics.metrics import gaps
from dubins_study.report.topics.summary import solver_summary

_GAPS = np.geomspace(1e-16, 10.0, 171)  # points of a curve, ten to a decade


def gap_shares(attempts: pd.DataFrame) -> pd.DataFrame:
    """The share of attempts within each gap.

    Rows are gaps, columns are solvers. Only questions that have an answer count.
    """
    ends = _GAPS * (1 + 1e-12)  # but for the rounding of the gaps
    groups = gaps(attempts).groupby(attempts["solver"])
    shares = {}
    for solver, solver_gaps in groups:
        within = np.searchsorted(np.sort(solver_gaps), ends, "right")
        shares[str(solver)] = within / len(solver_gaps)
    return pd.DataFrame(shares, pd.Index(_GAPS, name="gap"))


def success_section(results: Results) -> Section | None:
    """The section with a gap profile for each experiment."""
    palette = Palette.of_page(results)
    pictures = []
    for name in sorted({run.name for run in results.folders}):
        selection = results.only({name})
        if selection.attempts["answerable"].any():
            tolerance = max(run.manifest.gap_tolerance for run in selection.folders)
            pictures.append(_profile_picture(name, selection.attempts, tolerance, palette))
    if not pictures:
        return None
    text = (
        "Questions that have a path; every attempt counts, failed ones too. The gap is "
        "(length − reference) / max(reference, R). A path that does not arrive counts as an "
        "infinite gap."
    )
    lead = "See how often each method arrives, and how exact its paths are then."
    return Section("success", "Success and gaps", text, tuple(pictures), lead)


def _profile_picture(
    experiment: str, attempts: pd.DataFrame, tolerance: float, palette: Palette
) -> Picture:
    """The picture of one experiment's gap profile.

    Of many solvers, only the best of each engine are drawn, with a panel per formulation.
    """
    shares = gap_shares(attempts)
    caption = (
        f"Experiment {experiment}: share of attempts within each gap. Higher is more reliable, "
        "further left more accurate. A curve that ends below 100 %: some paths do not arrive."
    )
    if len(shares.columns) > MOST_METHODS:
        methods = solver_summary(attempts)
        best = drawn_methods(methods[methods["solver"].isin(shares.columns)])
        groups = best.groupby("formulation", sort=False)["solver"]
        panels = {str(title): shares[list(solvers)] for title, solvers in groups}
        names = dict(zip(best["solver"], best["short"], strict=True))
        curves = f"{DRAWN_TEXT} Grey: behind the first of a panel."
    else:
        named = foremost(shares[: 1.01 * tolerance].iloc[-1])
        panels = {"": shares}
        names = {solver: palette.label(solver) for solver in named}
        grey = len(shares.columns) - MOST_ENGINES
        curves = ""
        if grey > 0:
            curves = f"Grey, without names: {some(grey, 'solver')}, optimal least often."
    return panels_picture(
        f"gap-profile-{slug(experiment)}",
        sentences(caption, "Dotted: the largest gap of an optimal answer.", curves),
        share_curves,
        f"Share of attempts against gap, {experiment}",
        panels,
        names,
        palette,
        "gap to the shortest length (relative)",
        "share of all attempts",
        limit=tolerance,
    )


TOPIC = Topic("success and gaps", success_section, General.POOLED)
