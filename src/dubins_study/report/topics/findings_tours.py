"""What the study found of tours: what the optimum of a grid of headings is worth."""

from __future__ import annotations

from dubins_study.report.elements.formats import share, some
from dubins_study.report.topics.findings_evidence import Evidence, Finding
from dubins_study.report.topics.tours import (
    BEST_OF_GRID,
    PROVING,
    TITLE,
    against_proof,
    with_points,
)


def grid_optima(evidence: Evidence) -> Finding | None:
    """How many proved optima of a grid of headings are longer than the proved tour.

    Of the grid whose optima were proved on most tours.
    """
    rows = evidence.compared.answerable
    if not rows["formulation"].isin(PROVING).any():
        return None
    compared = against_proof(with_points(rows), evidence.settings)
    grids = compared[compared["kind"].str.startswith(BEST_OF_GRID)]
    if grids.empty:
        return None
    kind = grids["kind"].mode().iloc[0]
    optima = grids[grids["kind"] == kind].set_index("question")
    longer = optima["verdict"].eq("longer")
    refuted = evidence.share_of(longer.astype(float))
    if refuted is None or not longer.any():
        return None
    headings = kind.removeprefix(BEST_OF_GRID)
    return Finding(
        "Do not take the optimum of a grid for the shortest tour: with"
        f"{headings} a point, {refuted.percent_text()} are longer.",
        refuted,
        f"{some(refuted.questions, 'tour')} of which the grid's optimum and the shortest tour are "
        f"both proved; where it is longer, by {share(optima.loc[longer, 'gap'].median())} at the "
        f"median; {some(int(optima['other_order'].sum()), 'tour')} in another order",
        TITLE,
    )
