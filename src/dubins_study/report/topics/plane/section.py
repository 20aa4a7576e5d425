"""The section on the target plane."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, picture
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.report.topics.plane import figures
from dubins_study.report.topics.plane.numbers import along_circle, exact_answers


def plane_section(results: Results) -> Section | None:
    """Maps of words and lengths, and where the solvers on a coarse grid go wrong."""
    rows = results.rows[results.rows["branch"] == "best"]
    exact = exact_answers(rows)
    pictures: list[Picture] = []
    if len(exact):
        pictures += [_words(exact), _lengths(exact), _jump(exact)]
    coarse = rows[rows["solver"] != EXACT]
    names = Palette.of_page(results).names(coarse["solver"])
    for number, solver in enumerate(solver_order(coarse["solver"].tolist()), start=1):
        pictures.append(_failures(number, names[solver], coarse[coarse["solver"] == solver]))
    if not pictures:
        return None
    text = (
        "The vehicle starts at the origin and heads along +x; every point is a target. The paper "
        "states LS and RS only, which is right outside the two turning circles and wrong inside: "
        "there the shortest path turns away first. Across the front half of each circle (heavy) "
        "the length jumps by up to 2π R, and nowhere else."
    )
    lead = (
        "Look inside the two circles: there the shortest words are others than the paper's, and "
        "there solvers go wrong."
    )
    return Section("plane", "The target plane", text, tuple(pictures), lead)


def _words(exact: pd.DataFrame) -> Picture:
    caption = (
        "Shortest word by target. Hatched: inside a turning circle, where the first turn is away "
        "from the target. On the axis ahead the path is straight. Lengths in R."
    )
    alt = "Map of shortest words"
    return picture("plane-words", figures.plot_words, exact, caption=caption, alt=alt, height=3.5)


def _lengths(exact: pd.DataFrame) -> Picture:
    caption = (
        "Shortest length by target, a contour every R. The two discs stand out because the "
        "length jumps across the front half of their circles; across the rear half it is smooth."
    )
    alt = "Map of shortest lengths"
    return picture(
        "plane-lengths", figures.plot_lengths, exact, caption=caption, alt=alt, height=4.1
    )


def _jump(exact: pd.DataFrame) -> Picture:
    caption = (
        "The same lengths for the targets within one grid step of a turning circle, by their "
        "place on it. On the front half a target just inside costs up to 2π R more than one just "
        "outside; on the rear half the two sides meet."
    )
    table, alt = along_circle(exact), "Length on both sides of a turning circle"
    return picture("plane-jump", figures.plot_jump, table, caption=caption, alt=alt, height=3.5)


def _failures(number: int, name: str, rows: pd.DataFrame) -> Picture:
    group = rows.drop_duplicates(["target_x", "target_y"])
    right = int(success(group).sum())
    caption = f"{name}: {count(right)} of {count(len(group))} targets right; lengths in R."
    stem, alt = f"plane-solver-{number}", f"Targets {name} gets wrong"
    return picture(
        stem, figures.plot_failures, group, caption=caption, alt=alt, height=3.9, legend=2
    )


# Not compared: a plane has a hundred thousand questions that only the closed form answers.
TOPIC = Topic("the target plane", plane_section, "plane", (General.POOLED,))
