"""A finding on tours: what grids' optima are worth.

The grids are those of headings.
"""

from __future__ import annotations

from dubins_study.report.elements.formats import count, share, some
from dubins_study.report.topics.findings_evidence import Evidence, Finding
from dubins_study.report.topics.tours import (
    BEST_OF_GRID,
    PROVING,
    TITLE,
    against_proof,
    with_points,
)


def grid_optima(evidence: Evidence) -> Finding | None:
    """How often a grid's optimum has another order.

    The proved optima of a grid of headings are compared with the proved tours. Of several grids,
    the one with the most proved optima is taken.
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
    other_order = evidence.share_of(optima["other_order"].astype(float))
    if other_order is None or not optima["other_order"].any():
        return None
    longer = optima["verdict"].eq("longer")
    by_label = optima.groupby("label", sort=False)["other_order"].agg(["sum", "size"])
    parts = [f"{line.Index}: {line.sum} of {line.size}" for line in by_label.itertuples()]
    headings = kind.removeprefix(BEST_OF_GRID)
    return Finding(
        f"Do not take the order from a grid's optimum: with{headings} a point, "
        f"{other_order.percent_text()} of the optima have another order than the shortest tour.",
        other_order,
        f"{some(other_order.questions, 'tour')} of which the grid's optimum and the shortest tour "
        f"are both proved; {count(longer.sum())} optima are longer, by "
        f"{share(optima.loc[longer, 'gap'].median())} at the median; another order by density: "
        f"{', '.join(parts)}",
        TITLE,
    )
