"""The section on the target plane."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, count
from dubins_study.report.elements.style import HALF, new_figure
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.report.topics.plane.figures import (
    plot_failures,
    plot_jump,
    plot_lengths,
    plot_words,
)
from dubins_study.report.topics.plane.numbers import along_circle, exact_answers


def plane_section(results: Results) -> Section | None:
    """Maps of words and lengths, and where the solvers on a coarse grid go wrong."""
    rows = results.rows[results.rows["branch"] == "best"]
    exact = exact_answers(rows)
    pictures: list[Picture] = []
    if len(exact):
        pictures += [_words(exact), _lengths(exact), _jump(exact)]
    coarse = rows[rows["solver"] != EXACT]
    for number, solver in enumerate(solver_order(coarse["solver"].tolist()), start=1):
        pictures.append(_failures(number, solver, coarse[coarse["solver"] == solver]))
    if not pictures:
        return None
    text = (
        "The vehicle starts at the origin and heads along +x; every point is a target. The paper "
        "states LS and RS only, which is right outside the two turning circles and wrong inside: "
        "there the shortest path turns away first. Across the front half of each circle (heavy) "
        "the length jumps by up to 2π R, and nowhere else."
    )
    return Section("plane", "The target plane", text, tuple(pictures))


def _words(exact: pd.DataFrame) -> Picture:
    figure = new_figure(HALF, 3.5)
    plot_words(figure.add_subplot(), exact)
    caption = (
        "Shortest word by target. Hatched: inside a turning circle, where the first turn is away "
        "from the target. On the axis ahead the path is straight. Lengths in R."
    )
    return Picture("plane-words", caption, figure, "Map of shortest words", True)


def _lengths(exact: pd.DataFrame) -> Picture:
    figure = new_figure(HALF, 4.1)
    ax = figure.add_subplot()
    image = plot_lengths(ax, exact)
    bar = figure.colorbar(image, ax=ax, location="bottom", shrink=0.7, pad=0.02, aspect=28)
    bar.outline.set_visible(False)
    bar.set_label("shortest length / R")
    caption = (
        "Shortest length by target, a contour every R. The two discs stand out because the "
        "length jumps across the front half of their circles; across the rear half it is smooth."
    )
    return Picture("plane-lengths", caption, figure, "Map of shortest lengths", True)


def _jump(exact: pd.DataFrame) -> Picture:
    figure = new_figure(HALF, 3.5)
    plot_jump(figure.add_subplot(), along_circle(exact))
    caption = (
        "The same lengths for the targets within one grid step of a turning circle, by their "
        "place on it. On the front half a target just inside costs up to 2π R more than one just "
        "outside; on the rear half the two sides meet."
    )
    return Picture("plane-jump", caption, figure, "Length on both sides of a turning circle", True)


def _failures(number: int, solver: str, rows: pd.DataFrame) -> Picture:
    figure = new_figure(HALF, 3.9)
    group = rows.drop_duplicates(["target_x", "target_y"])
    plot_failures(figure.add_subplot(), group)
    figure.legend(loc="outside lower left", ncols=2, fontsize=7.5)
    right = int(success(group).sum())
    caption = f"{solver}: {count(right)} of {count(len(group))} targets right; lengths in R."
    return Picture(f"plane-solver-{number}", caption, figure, f"Targets {solver} gets wrong", True)
