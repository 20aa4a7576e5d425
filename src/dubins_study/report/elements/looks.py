"""How a solver is drawn and named: a solver looks the same in all figures of a page."""

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
# Eight hues and eleven markers: their combinations repeat only after 88 solvers.
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
        """Keywords for markers without a line."""
        return {"color": self.colour, "marker": self.marker, "linestyle": "none"}

    @property
    def lines(self) -> dict[str, Any]:
        """Keywords for a line without markers."""
        return {"color": self.colour, "linestyle": self.line}

    def curve(self, place: int) -> dict[str, Any]:
        """Keywords for a line of many points with a few markers.

        The markers distinguish curves in grey print. `place` is the index of the curve in its
        figure; it shifts the markers, so that markers of coinciding curves do not overlap.
        """
        every = (0.03 + 0.045 * (place % 5), 0.22)
        return {**self.lines, "marker": self.marker, "markevery": every, "markersize": 3.5}


@dataclass(frozen=True)
class Palette:
    """A hue and a marker per solver name, assigned in the order of the names.

    Args:
        hues: name -> colour and marker.
    """

    hues: dict[str, tuple[str, str]]

    @classmethod
    def of(cls, specs: Iterable[str]) -> Self:
        """The palette of all solvers of a page; variants of a solver share hue and marker.

        The closed form, the reference in every figure, is drawn in the text's colour.
        """
        names = dict.fromkeys(parse_spec(spec)[0] for spec in solver_order(list(specs)))
        others = [name for name in names if name != EXACT]
        hues = {
            name: (_HUES[i % len(_HUES)], _MARKERS[i % len(_MARKERS)])
            for i, name in enumerate(others)
        }
        return cls({EXACT: (style.INK, "o")} | hues)

    def looks(self, specs: Iterable[str]) -> dict[str, Look]:
        """A look for each solver of a figure; line styles distinguish the variants of a solver."""
        result: dict[str, Look] = {}
        variants: dict[str, int] = {}
        for spec in solver_order(list(specs)):
            name = parse_spec(spec)[0]
            variant = variants[name] = variants.get(name, -1) + 1
            result[spec] = Look(*self.hues[name], LINES[variant % len(LINES)])
        return result


def name_of(solver: str, width: int = 26) -> str:
    """A solver's name for a figure, with its settings on separate lines."""
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
    """Largest number of lines that one of the names takes."""
    return max(name_of(solver).count("\n") + 1 for solver in solvers)


def legend_lines(solvers: Iterable[str], width: int = 26, columns: int = 1) -> int:
    """Approximate number of text lines in a legend of these solvers."""
    lines = [name_of(solver, width).count("\n") + 1 for solver in solvers]
    return math.ceil(len(lines) / columns) * max(lines, default=1) if columns > 1 else sum(lines)
