"""The section on the radius sweep."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import WIDE, new_figure
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import best_solvers
from dubins_study.report.topics.radius.figures import plot_length, plot_time
from dubins_study.report.topics.radius.numbers import (
    VISIBLE,
    Sweep,
    answers,
    cold,
    sweep,
    sweep_rows,
)


def radius_section(results: Results) -> Section | None:
    """One figure per sweep, and how the answers along the sweeps are wrong."""
    rows_of_sweeps = sweep_rows(results.rows)
    if not rows_of_sweeps:
        return None
    rows, palette = pd.concat(list(rows_of_sweeps.values())), Palette.of_page(results)
    solvers = best_solvers(cold(rows))
    blocks: list[Picture | Table] = [
        _picture(number, sweep(label, group), solvers, palette)
        for number, ((_, label), group) in enumerate(rows_of_sweeps.items(), start=1)
    ]
    blocks.append(_answers(answers(rows)))
    text = (
        "At R* = r² / (2 |Y|) a turning circle passes through the target (r is its distance, Y its "
        "offset to the left of the start heading). Beyond it the target lies inside the circle, "
        "the word changes, and where it lay on the circle's front half the length jumps. Left: the "
        "shortest length (heavy) with its word at the top, and in grey LS (dashed) and RS (dotted) "
        f"where they exist; open marks are answers more than {_VISIBLE} longer, crosses at "
        "the foot those that do not arrive. Right: the median time of a cold attempt, of the "
        "closed form and of each formulation's solver that is most surely right."
    )
    lead = (
        "See where the target enters a turning circle, at R*: there the word changes, the length "
        "jumps where the target was ahead, and some solvers take longer."
    )
    title = "Length, time and word against radius"
    return Section("radius", title, text, tuple(blocks), lead)


_VISIBLE = f"{100 * VISIBLE:g} %"
_HEIGHT = 2.75  # inches
# Panels as shares of the figure: left, bottom, width, height; to the right the curves' names.
_LENGTH, _TIME = (0.08, 0.165, 0.36, 0.74), (0.545, 0.165, 0.24, 0.74)


def _picture(number: int, sweep: Sweep, solvers: list[str], palette: Palette) -> Picture:
    figure = new_figure(WIDE, _HEIGHT)
    figure.set_layout_engine("none")  # the names' places depend on those of the panels
    left, right = figure.add_axes(_LENGTH), figure.add_axes(_TIME)
    plot_length(left, sweep, palette)
    plot_time(right, sweep, [s for s in solvers if s in set(sweep.times["solver"])], palette)
    for ax in (left, right):
        ax.set_xlabel("turning radius R")
    label = sweep.label
    caption = f"{label[:1].upper()}{label[1:]}. Length units; R* = {digits(5)(sweep.circle)}."
    return Picture(f"radius-{number}", caption, figure, f"Length and time over radius, {label}")


def _answers(frame: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, attempts="attempts", right="shortest"),
        *columns(count, little=f"up to {_VISIBLE} longer", longer="more", lost="no path"),
        *columns(digits(2), most="largest gap"),
    )
    caption = (
        "What the solvers answer along the sweeps, cold and warm: the shortest path within the "
        "check's tolerance, a longer one, or none that arrives. The gap is relative."
    )
    return Table("radius-answers", caption, frame, shown, marks(frame, "longer", "lost"))


TOPIC = Topic("length, time and word against radius", radius_section, General.EVERY)
