"""A drawing of one path."""

from __future__ import annotations

import logging
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Protocol, cast, runtime_checkable

import numpy as np
from matplotlib.axes import Axes

from dubins_study.errors import DubinsStudyError
from dubins_study.report.elements.style import INK, drawing, figure_bytes, fix_layout, new_figure
from dubins_study.report.topics.paper_figures import labelled, plot_paths
from dubins_study.report.topics.routes import plot_route
from dubins_study.study.kinds.table import kind_of
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT
from dubins_study.study.values import short, unwritable
from dubins_study.study.words import Verdict, short_word

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOG = logging.getLogger(__name__)
_WIDTH = 5.5  # inches
_HEIGHT = (3.0, 8.0)
_LEGEND_CHARS = 60
_FORMATS = (".svg", ".pdf", ".png")


class PlotError(DubinsStudyError, ValueError):
    """The path cannot be drawn, or not saved."""


@runtime_checkable
class Answered(Protocol):
    """An answer that can be drawn.

    `dubins_study.solve` returns one. If the answer also has a branch and a verdict `longer` or
    `misses`, it is drawn beside the shortest path.
    """

    @property
    def scenario(self) -> Scenario: ...
    @property
    def path(self) -> Path | None: ...
    @property
    def solver(self) -> str: ...


def plot_path(
    drawn: Answered | Path,
    file: str | FilePath | None = None,
    *,
    ax: Axes | None = None,
    names: Sequence[str] = (),
    geographic: bool = False,
) -> Figure:
    """Draw a path, its circles, start and target.

    An answer that the check finds longer than the shortest path, or to miss the target, is drawn
    beside the shortest path of its branch.

    Args:
        drawn: an answer of `dubins_study.solve`, or a path. For a path, the target is the path's
            end, and the turning radius is that of its sharpest arc.
        file: where to save the figure, with suffix .svg, .pdf or .png; None: do not save it.
        ax: axes to draw on; None: those of a new figure.
        names: of the via points, then of the target; some may be empty, and some left out.
        geographic: whether lengths are metres, x points east and y north: the axes say so, with a
            scale bar and an arrow to the north.

    Returns:
        The figure, that of the axes if they are given.

    Raises:
        PlotError: if there is no path, a number of it is not finite, `drawn` or `ax` is something
            else, the format is unknown or the file cannot be written.
    """
    place = None
    if file is not None:
        place = check_format(file)
    if ax is not None and not isinstance(ax, Axes):
        raise PlotError(f"ax is {short(ax)}; expected axes of matplotlib")
    name, path, scenario = _subject(drawn)
    # a long spec is broken between its settings: the legend is as wide as the figure
    lines = textwrap.fill(name.replace(",", ", "), _LEGEND_CHARS, break_on_hyphens=False)
    named_paths = {lines: path}
    if (reference := _reference(drawn)) is not None:
        named_paths = {"shortest": reference, **named_paths}
    status = _status_text(drawn, geographic)
    with drawing(), _one_warning_of_letters():
        if ax is None:
            figure = new_figure(_WIDTH, _HEIGHT[1])
            axes = figure.add_subplot()
            _plot(axes, named_paths, scenario, names, status, geographic)
            aspect = axes.dataLim.height / axes.dataLim.width
            figure.set_size_inches(_WIDTH, min(max(_WIDTH * aspect + 0.6, _HEIGHT[0]), _HEIGHT[1]))
            fix_layout(figure)
        else:
            figure = cast("Figure", ax.get_figure(root=True))
            _plot(ax, named_paths, scenario, names, status, geographic)
        if place is not None:
            image = figure_bytes(figure, place.suffix.lower().removeprefix("."))
            try:
                place.write_bytes(image)
            except OSError as error:
                raise PlotError(f"cannot write {place}: {error.strerror}") from None
    return figure


@contextmanager
def _one_warning_of_letters() -> Iterator[None]:
    """Log one warning if the font lacks letters.

    Matplotlib warns of each such letter of a name. These warnings are dropped; all others are
    raised again.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    unrelated = [warning for warning in caught if "missing from font" not in str(warning.message)]
    for warning in unrelated:
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if len(unrelated) < len(caught):
        _LOG.warning("dubins-study: the plot's font lacks letters of a name; boxes stand for them")


def _status_text(drawn: object, geographic: bool) -> str:
    """The title's text behind the length: ` m, proved`.

    It names the verdict, or `proved` if the answer is proved. A unit is added if `geographic`, and
    the travel time if the scenario's speed is not 1. The text is empty if nothing is known.
    """
    text = ""
    second = ""
    if geographic:
        text = " m"
        second = " s"
    status = getattr(drawn, "verdict", None)
    if getattr(drawn, "proof", None) == "proved":
        status = "proved"
    if status:
        text += f", {status}"
    time = getattr(drawn, "travel_time", None)
    scenario = getattr(drawn, "scenario", None)
    if time is not None and isinstance(scenario, Scenario) and scenario.speed != 1:
        text += f", time {time:.4g}{second}"
    return text


def _mark_earth(ax: Axes) -> None:
    """Label the axes in metres; add scale and north.

    A scale bar and an arrow to the north stand above the panel.
    """
    from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

    ax.set_xlabel(ax.get_xlabel().replace("x", "east (m)", 1))
    ax.set_ylabel("north (m)")
    most = ax.dataLim.width / 4
    power = 10.0 ** np.floor(np.log10(most))
    bar = max(step * power for step in (1, 2, 5) if step * power <= most)
    scale_bar = AnchoredSizeBar(
        ax.transData,
        bar,
        f"{bar:g} m",
        loc="lower right",
        frameon=False,
        label_top=True,
        bbox_to_anchor=(0.95, 1),
        bbox_transform=ax.transAxes,
    )
    ax.add_artist(scale_bar)
    ax.annotate(
        "N",
        (0.98, 1.005),
        (0, 24),
        xycoords="axes fraction",
        textcoords="offset points",
        ha="center",
        arrowprops={"arrowstyle": "<|-", "color": INK},
    )


def _plot(
    ax: Axes,
    named_paths: Mapping[str, Path],
    scenario: Scenario,
    names: Sequence[str],
    status: str,
    geographic: bool,
) -> None:
    """Draw named paths of one scenario on the axes.

    `named_paths` has one or two paths for a leg with a free final heading, and one path for all
    other scenarios.
    """
    if kind_of(scenario).drawing == "route":
        [(name, path)] = named_paths.items()
        plot_route(ax, path, scenario, name, names, status)
    else:
        _plot_leg(ax, named_paths, scenario, status)
    if geographic:
        _mark_earth(ax)


def _plot_leg(ax: Axes, named_paths: Mapping[str, Path], scenario: Scenario, status: str) -> None:
    """Draw one or two paths of one leg.

    `status` (verdict and time) is added to the last path's name only: it is the answer's.
    """
    texts = {
        labelled(name, short_word(path.word(1e-2), 24) or "–", path): path
        for name, path in named_paths.items()
    }
    last_name, path = texts.popitem()
    texts[f"{last_name}{status}"] = path
    plot_paths(ax, texts, scenario)


def check_format(file: str | FilePath) -> FilePath:
    """The file as a path.

    Raises:
        PlotError: if its suffix is not .svg, .pdf or .png, or it cannot be written.
    """
    place = FilePath(file)
    if place.suffix.lower() not in _FORMATS:
        raise PlotError(f"file is {str(file)!r}; expected a name ending in .svg, .pdf or .png")
    if reason := unwritable(place):  # before a solve that may take long
        raise PlotError(f"cannot write {place}: {reason}")
    return place


def _reference(drawn: object) -> Path | None:
    """The shortest path to draw beside a worse answer.

    The path is that of the answer's branch. None comes back unless the answer is longer or misses
    the target.
    """
    branch = getattr(drawn, "branch", None)
    scenario = getattr(drawn, "scenario", None)
    judged_badly = getattr(drawn, "verdict", None) in (Verdict.LONGER, Verdict.MISSES)
    if not (judged_badly and isinstance(branch, str) and isinstance(scenario, Scenario)):
        return None
    kind = kind_of(scenario)
    if kind.drawing != "circles" or branch not in kind.branches:
        return None
    return kind.reference(scenario, branch, DEFAULT).path


def _subject(drawn: Answered | Path) -> tuple[str, Path, Scenario]:
    """Name for the legend, path, and its scenario."""
    path = getattr(drawn, "path", None)
    if isinstance(drawn, Path):
        path = drawn
    with np.errstate(all="ignore"):
        if isinstance(path, Path) and not np.isfinite(path.poses).all():
            raise PlotError("the path is not finite")
    if isinstance(drawn, Path):
        sharpest = float(np.abs(drawn.curvatures).max(initial=0.0))
        radius = 1.0
        if sharpest > 0:
            radius = 1 / sharpest
        end = drawn.end
        return "path", drawn, Scenario(*drawn.start, end.x, end.y, radius, _radians=True)
    if isinstance(drawn, type) or not isinstance(drawn, Answered):
        raise PlotError(f"drawn is {short(drawn)}; expected an answer of solve, or a Path")
    if drawn.path is None:
        raise PlotError(f"there is no path to draw: {drawn.solver} returned none")
    return drawn.solver, drawn.path, drawn.scenario
