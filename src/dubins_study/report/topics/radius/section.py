"""The section on the radius sweep."""

from __future__ import annotations

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import HALF, new_figure
from dubins_study.report.topics.radius.figures import WARM, plot_length, plot_time
from dubins_study.report.topics.radius.numbers import Sweep, sweep, sweep_rows
from dubins_study.report.topics.warm.numbers import warm_starts
from dubins_study.report.topics.warm.section import warm_blocks, warm_sentences


def radius_section(results: Results) -> Section | None:
    """One figure per sweep, and cold against warm starts."""
    rows_of_sweeps = sweep_rows(results.rows)
    if not rows_of_sweeps:
        return None
    palette = Palette.of_page(results)
    blocks: list[Picture | Table] = [
        _picture(number, sweep(label, group), palette)
        for number, ((_, label), group) in enumerate(rows_of_sweeps.items(), start=1)
    ]
    warm = warm_starts(pd.concat(list(rows_of_sweeps.values())))
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


def _picture(number: int, sweep: Sweep, palette: Palette) -> Picture:
    figure = new_figure(HALF, 4.1)
    upper, lower = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    plot_length(upper, sweep, palette)
    plot_time(lower, sweep, palette)
    handles, texts = _solvers_only(lower)
    figure.legend(handles, texts, loc="outside lower left", ncols=2, fontsize=7.5)
    label = sweep.label
    caption = f"{label[:1].upper()}{label[1:]}. Length units; R* = {digits(5)(sweep.circle)}."
    alt = f"Length and time over radius, {label}"
    return Picture(f"radius-{number}", caption, figure, alt, True)


def _solvers_only(ax: Axes) -> tuple[list[Artist], list[str]]:
    """Legend entries without those of warm starts, which the text explains."""
    pairs = zip(*ax.get_legend_handles_labels(), strict=True)
    kept = [(handle, text) for handle, text in pairs if not text.endswith(WARM)]
    return [handle for handle, _ in kept], [text for _, text in kept]
