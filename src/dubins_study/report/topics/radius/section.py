"""The section on the radius sweep."""

from __future__ import annotations

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.page.content import Picture, Section, Table, digits
from dubins_study.report.page.style import HALF, new_figure
from dubins_study.report.statistics.metrics import circle_radius
from dubins_study.report.statistics.timing import warm_starts
from dubins_study.report.topics.radius.figures import WARM, plot_length, plot_time
from dubins_study.report.topics.warm.section import warm_blocks, warm_sentences

_FEWEST_RADII = 4  # below that there is no curve to see
_PLACE = ["x", "y", "heading", "target_x", "target_y"]


def sweeps(rows: pd.DataFrame) -> dict[tuple[str, str], pd.DataFrame]:
    """(experiment, label) -> its rows, where one start and target are asked at many radii."""
    best = rows[rows["branch"] == "best"]
    found = {}
    for (experiment, label), own in best.groupby(["experiment", "label"], sort=True):
        if own["radius"].nunique() >= _FEWEST_RADII and len(own[_PLACE].drop_duplicates()) == 1:
            found[str(experiment), str(label)] = own
    return found


def radius_section(results: Results) -> Section | None:
    """One figure a sweep, and cold against warm starts."""
    found = sweeps(results.rows)
    if not found:
        return None
    blocks: list[Picture | Table] = [
        _picture(number, label, own)
        for number, ((_, label), own) in enumerate(found.items(), start=1)
    ]
    rows = pd.concat(list(found.values()))
    warm = warm_starts(rows)
    if len(warm):
        blocks += warm_blocks(warm)
    text = (
        "At R* = r² / (2 |Y|) a turning circle passes through the target (r is its distance, Y its "
        "offset to the left of the start heading). Beyond it the target lies inside the circle, "
        "the word changes, and where it lay on the circle's front half the length jumps. Upper "
        "panels: the shortest length (heavy) with its word, and in grey LS (dashed) and RS "
        "(dotted) where they exist; open marks are answers that are longer, crosses at the foot "
        "those that do not arrive. Lower panels: time of one attempt, cold (solid) and warm "
        "(dotted)."
    )
    if len(warm):
        text += f" {warm_sentences(warm)}"
    return Section("radius", "Length, time and word against radius", text, tuple(blocks))


def _picture(number: int, label: str, rows: pd.DataFrame) -> Picture:
    first = rows.iloc[0]
    circle = circle_radius(*(first[key] for key in _PLACE))
    figure = new_figure(HALF, 4.1)
    upper, lower = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    plot_length(upper, rows, circle)
    plot_time(lower, rows, circle)
    handles, texts = _solvers_only(lower)
    figure.legend(handles, texts, loc="outside lower left", ncols=2, fontsize=7.5)
    caption = f"{label[:1].upper()}{label[1:]}. Length units; R* = {digits(5)(circle)}."
    return Picture(
        f"radius-{number}", caption, figure, f"Length and time over radius, {label}", True
    )


def _solvers_only(ax: Axes) -> tuple[list[Artist], list[str]]:
    """Legend entries without the warm ones: the caption tells how warm is drawn."""
    pairs = zip(*ax.get_legend_handles_labels(), strict=True)
    kept = [(handle, text) for handle, text in pairs if not text.endswith(WARM)]
    return [handle for handle, _ in kept], [text for _, text in kept]
