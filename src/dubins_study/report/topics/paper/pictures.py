"""The paper's figures, drawn again from the paths in the rows."""

from __future__ import annotations

import math

import pandas as pd

from dubins_study.report.elements.axes import duration
from dubins_study.report.elements.content import Picture, picture
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import HALF, WIDE, new_figure
from dubins_study.report.topics.paper import figures
from dubins_study.report.topics.paper.numbers import TICK_S
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.scenario import Scenario

# Any target ahead and to the left shows what Figure 3.1 shows; the paper gives no numbers.
_FEASIBLE = Scenario(heading=math.radians(75), target_x=4.6, target_y=2.4)
_ALONE = (1, 3)  # test problems with one panel in the paper; 2 and 4 have two
_NEAR = 28.0  # length units around the start, where the paths of test problem 5 differ
_LABELS, _LEAST, _MOST = 0.55, 1.6, 3.1  # inches: below and above a panel; a panel


def feasible_picture() -> Picture:
    """Figure 3.1 for a target of our own."""
    paths = [shortest_path(_FEASIBLE, word) for word in ("LS", "RS")]
    return picture(
        "paths-feasible",
        figures.plot_feasible,
        *(_FEASIBLE, *paths),
        caption="As the paper's Figure 3.1. From P the vehicle turns left to X₁ or right to X₂, "
        "then drives straight to X₃ = T: the feasible paths LS and RS. Faint: the turning circles.",
        alt="The paths LS and RS from a start to a target",
        height=2.5,
    )


def problem_picture(problem: int, paths: pd.DataFrame) -> Picture:
    """The paper's figure of one test problem; `paths` are those of `numbers.problem_paths`."""
    if problem == 5:
        return _radii_picture(paths)
    draw = _one_panel if problem in _ALONE or len(paths) < 2 else _two_panels
    return draw(problem, paths)


def _one_panel(problem: int, paths: pd.DataFrame) -> Picture:
    return picture(
        f"paths-{problem}",
        figures.plot_both_words,
        paths,
        caption=f"Figure 6.{problem}. Optimal (solid) and feasible (dashed) path with their "
        "lengths; length units.",
        alt=f"Paths of test problem {problem}",
        height=_LABELS + _panel_height(paths, HALF),
    )


def _two_panels(problem: int, paths: pd.DataFrame) -> Picture:
    """Panels side by side for a high figure, one below the other for a wide one."""
    aspect = figures.aspect_of(paths)
    down, across = (1, 2) if aspect > 1 else (2, 1)
    height = down * (_LABELS + _panel_height(paths, HALF / across))
    figure = new_figure(HALF, height)
    axes = figure.subplots(down, across, squeeze=False).flat
    for rank, (ax, title) in enumerate(zip(axes, ("(a) optimal", "(b) feasible"), strict=True), 1):
        figures.plot_one_word(ax, paths, rank, title)
        ax.label_outer()
    caption = (
        f"Figure 6.{problem}. The optimal and the feasible path with their lengths; length units."
    )
    alt = f"Paths of test problem {problem}, each in its panel"
    return Picture(f"paths-{problem}", caption, figure, alt, half=True)


def _panel_height(paths: pd.DataFrame, width: float) -> float:
    return min(max((width - 0.5) * figures.aspect_of(paths) * 1.1, _LEAST), _MOST)


def _radii_picture(paths: pd.DataFrame) -> Picture:
    figure = new_figure(WIDE, 2.4)
    whole, near = figure.subplots(1, 2, width_ratios=(7, 4))
    figures.plot_radii(whole, paths, math.inf)
    figures.plot_radii(near, paths, _NEAR)
    whole.legend(loc="lower left", borderaxespad=0.1)
    whole.set_title("whole paths")
    near.set_title("near the start")
    caption = (
        "Figure 6.5. Optimal paths of test problem 5 for three turning radii with their lengths, "
        "and the same paths near the start, where they differ; faint: the turning circles. Length "
        "units."
    )
    return Picture("paths-5", caption, figure, "Paths of test problem 5 for three radii")


def times_picture(times: pd.DataFrame, solvers: list[str], palette: Palette) -> Picture:
    """The printed solve times and ours; `times` are those of `numbers.printed_times`."""
    lines = times.groupby(["label", "path"]).ngroups
    return picture(
        "paper-times",
        figures.plot_times,
        *(times[times["solver"].isin(solvers)], solvers, palette),
        caption="The paper's printed solve times (crosses) beside the median times of ours: the "
        "closed form and of each formulation the solver that is most surely right. Dotted: "
        f"whole ticks of a clock of 64 a second, {duration(TICK_S)} each.",
        alt="Printed solve times on whole ticks of a clock, beside the times of our solvers",
        height=1.2 + 0.24 * lines + 0.16 * math.ceil(len(solvers) / 3),
        width=WIDE,
        legend=3,
    )
