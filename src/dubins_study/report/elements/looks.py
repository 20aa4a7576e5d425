"""How a solver is drawn and named: the same solver looks the same in all figures of a page."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.elements import style
from dubins_study.report.statistics.metrics import parse_spec, solver_order

LineStyle = str | tuple[int, tuple[float, ...]]
LINES: tuple[LineStyle, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (5, 1.5, 1, 1.5)))
# eight hues and eleven markers: their pairs repeat only after 88 solvers
_OKABE_ITO = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY)
_HUES = (*_OKABE_ITO, style.BROWN, style.OLIVE)
_MARKERS = ("^", "s", "D", "v", "P", "X", "p", "*", "<", ">", "h")


class Look(NamedTuple):
    """How a solver is drawn."""

    colour: str
    marker: str
    line: LineStyle

    @property
    def dots(self) -> dict[str, Any]:
        """Keywords for markers alone."""
        return {"color": self.colour, "marker": self.marker, "linestyle": "none"}

    @property
    def lines(self) -> dict[str, Any]:
        """Keywords for a line without markers."""
        return {"color": self.colour, "linestyle": self.line}

    def curve(self, place: int) -> dict[str, Any]:
        """Keywords for a line of many points, with a marker now and then.

        Markers tell curves apart in grey print. `place` is the curve's position in its figure: it
        shifts the markers, so that those of coinciding curves do not cover each other.
        """
        every = (0.03 + 0.045 * (place % 5), 0.22)
        return {**self.lines, "marker": self.marker, "markevery": every, "markersize": 3.5}


@dataclass(frozen=True)
class Palette:
    """A hue and a marker for each name, given in the names' order.

    Args:
        hues: name -> colour and marker.
    """

    hues: dict[str, tuple[str, str]]

    @classmethod
    def of(cls, specs: Iterable[str]) -> Self:
        """The palette of all solvers of a page; variants of a solver share hue and marker.

        The closed form, every figure's reference, is drawn in ink.
        """
        names = dict.fromkeys(parse_spec(spec)[0] for spec in solver_order(list(specs)))
        others = [name for name in names if name != EXACT]
        hues = {
            name: (_HUES[i % len(_HUES)], _MARKERS[i % len(_MARKERS)])
            for i, name in enumerate(others)
        }
        return cls({EXACT: (style.INK, "o")} | hues)

    def looks(self, specs: Iterable[str]) -> dict[str, Look]:
        """A look for each solver of a figure; line styles tell the variants of one solver apart."""
        result: dict[str, Look] = {}
        variants: dict[str, int] = {}
        for spec in solver_order(list(specs)):
            name = parse_spec(spec)[0]
            variant = variants[name] = variants.get(name, -1) + 1
            result[spec] = Look(*self.hues[name], LINES[variant % len(LINES)])
        return result


def name_of(solver: str, width: int = 26) -> str:
    """A solver's name for a figure, settings on lines of their own."""
    name, settings = parse_spec(solver)
    lines, line = [name], ""
    for key, value in settings.items():
        item = f"{key}={value}"
        if line and len(line) + len(item) + 2 > width:
            lines.append(line)
            line = item
        else:
            line = f"{line}, {item}" if line else item
    return "\n".join(part[:60] for part in (*lines, line) if part)


def lines_of_names(solvers: Iterable[str]) -> int:
    """How many lines the longest of the names takes."""
    return max(name_of(solver).count("\n") + 1 for solver in solvers)


def legend_lines(solvers: Iterable[str], width: int = 26, columns: int = 1) -> int:
    """About how many lines of text a legend of these solvers takes."""
    lines = [name_of(solver, width).count("\n") + 1 for solver in solvers]
    return math.ceil(len(lines) / columns) * max(lines, default=1) if columns > 1 else sum(lines)
