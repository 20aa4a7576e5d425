"""How a solver is drawn and named: an engine looks the same in all figures of all pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements import style
from dubins_study.report.elements.names import figure_names, names_of
from dubins_study.report.statistics.metrics import natural, parse_spec, solver_order

LineStyle = str | tuple[int, tuple[float, ...]]
LINES: tuple[LineStyle, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (5, 1.5, 1, 1.5)))
# Ten hues and eleven markers: their combinations repeat only after 110 engines.
_MARKERS = ("^", "s", "D", "v", "P", "X", "p", "*", "<", ">", "h")
# Engines in the order in which they get hues and markers; those that meet in most figures come
# first, so that they differ in hue. Engines that the list does not name follow by name.
_ENGINES = (
    *("Ipopt", "SLSQP", "fatrop", "Bonmin", "SLEQP", "trust-constr", "Uno", "Uno filterSQP"),
    *("casadi sqpmethod", "NLopt SLSQP", "APOPT", "COBYQA", "alpaqa", "casadi qrsqp"),
    *("NLopt AUGLAG", "NLopt COBYLA", "SCIP", "MAiNGO", "Clarabel", "MINPACK lm", "OSQP"),
    *("CMA-ES", "PIQP", "DIRECT", "MINPACK hybr", "Nelder-Mead", "Powell", "SHGO"),
    *("dual annealing", "HiGHS", "differential evolution"),
)
_FORMULA = "closed form"
# A curve that is there to compare with, behind those that have a colour and a name.
BEHIND: style.Style = {"color": style.RULE, "linewidth": 0.8, "zorder": 1.5}


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


@dataclass(frozen=True)
class Palette:
    """A hue and a marker per engine."""

    hues: dict[str, tuple[str, str]]  # engine -> colour and marker
    # spec -> its engine; a spec that is missing counts as an engine by its solver's name
    engines: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)  # spec -> its short name on the page

    @classmethod
    def of_page(cls, results: Results) -> Self:
        """The palette of all engines of a page, by its solvers' specs."""
        names = names_of(results)
        engines = {str(spec): str(engine) for spec, engine in names["engine"].items()}
        labels = {str(spec): str(label) for spec, label in names["label"].items()}
        hues = cls.of(engines.values()).hues
        # A solver's name without its settings stands for the engine of its first spec.
        first = {parse_spec(spec)[0]: engines[spec] for spec in reversed(solver_order([*engines]))}
        hues = {name: hues[engine] for name, engine in first.items()} | hues
        return cls(hues, engines, labels)

    @classmethod
    def of(cls, engines: Iterable[str]) -> Self:
        """The palette of some engines, or of solvers by their names.

        The closed form, the reference in every figure, is drawn in the text's colour.
        """
        names = {parse_spec(engine)[0] for engine in engines} - {EXACT, _FORMULA}
        others = sorted(names - set(_ENGINES), key=natural)
        hues = {
            name: (style.ENGINE_HUES[i % len(style.ENGINE_HUES)].light, _MARKERS[i % len(_MARKERS)])
            for i, name in enumerate((*_ENGINES, *others))
        }
        reference = (style.INK, "o")
        return cls({EXACT: reference, _FORMULA: reference} | hues)

    def looks(self, specs: Iterable[str]) -> dict[str, Look]:
        """A look for each solver of a figure; line styles distinguish those of one hue."""
        result: dict[str, Look] = {}
        used: dict[str, int] = {}
        for spec in solver_order(list(specs)):
            colour, marker = self.hues[self.engines.get(spec, parse_spec(spec)[0])]
            place = used[colour] = used.get(colour, -1) + 1
            # Hues that are alike in grey begin with other dashes.
            first = self._dashes.get(colour, 0)
            result[spec] = Look(colour, marker, LINES[(first + place) % len(LINES)])
        return result

    @property
    def _dashes(self) -> dict[str, int]:
        return {hue.light: place % len(LINES) for place, hue in enumerate(style.ENGINE_HUES)}

    def names(self, specs: Iterable[str]) -> dict[str, str]:
        """The names of a figure's solvers: of a short name only what tells them apart."""
        return figure_names({spec: self.label(spec) for spec in specs})

    def label(self, spec: str) -> str:
        """A solver's short name; its spec, over several lines, if the page has none."""
        return self.labels.get(spec) or name_of(spec)


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
