"""How a solver is named and drawn.

A solver has one name on a page. An engine has one hue and one marker.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, cycle
from typing import Any, NamedTuple, Self, TypeAlias

import pandas as pd

from dubins_study.report.data.attempts import EXACT, own_name
from dubins_study.report.data.results import Results
from dubins_study.report.elements import style
from dubins_study.report.elements.formats import shortened
from dubins_study.report.statistics.methods import UNSTATED, methods_of, once
from dubins_study.report.statistics.metrics import natural, parse_spec, solver_order
from dubins_study.study.words import FORMULATION_LIST

_FORMULATIONS = {formulation.name: formulation.short for formulation in FORMULATION_LIST}
_MOST_CHARACTERS = 70
Names: TypeAlias = Mapping[str, str]  # solver -> its name


@once
def names_of(results: Results) -> pd.DataFrame:
    """A frame of the page's methods, with labels.

    It is the frame of `methods_of`, indexed by solver, with a column `label`: a short name such as
    `Ipopt, joint LRS, zero start`. A selection of the page's results gives the frame of the whole
    page.
    """
    methods = methods_of(results.methods)
    return methods.assign(label=pd.Series(short_labels(methods), dtype=object))


def labels_of(results: Results) -> dict[str, str]:
    """Map each solver to its short name."""
    return {str(solver): str(label) for solver, label in names_of(results)["label"].items()}


def in_page_order(frame: pd.DataFrame, results: Results) -> pd.DataFrame:
    """The rows sorted by solver in the page's order.

    Rows of one solver keep their order.
    """
    place = {solver: number for number, solver in enumerate(names_of(results).index)}
    return frame.sort_values(
        "solver", key=lambda solvers: solvers.map(place), kind="stable", ignore_index=True
    )


def short_labels(methods: pd.DataFrame) -> dict[str, str]:
    """Map each solver to a distinct short name.

    A name has the engine, the formulation, the initial guess, and the settings that differ.
    """
    rows = methods.reset_index(names="solver").to_dict("records")
    labels = distinct([short_label(row) for row in rows])
    return {str(row["solver"]): label for row, label in zip(rows, labels, strict=True)}


def short_label(row: Mapping[Hashable, Any]) -> str:
    """The short name of one method.

    `row` is a row of the frame of `methods_of`, with its solver. Two methods may get the same name;
    `distinct` numbers them.
    """
    formulation = str(row["formulation"])
    engine = str(row["engine"])
    spec = str(row["solver"])
    settings = str(row["settings"])
    if engine == UNSTATED:
        return one_line(spec)
    if own_name(spec):
        return one_line(", ".join(filter(None, [engine, settings])))
    method = [engine]
    if formulation != engine:
        method.append(_FORMULATIONS.get(formulation, formulation))
    method.append(str(row["variant"]).removesuffix(settings).removesuffix(", "))  # the guess
    name = ", ".join(filter(None, [*method, settings]))
    # the settings of a long name that come last are those that a study varies
    while len(name) > _MOST_CHARACTERS and ", " in settings:
        settings = settings.partition(", ")[2]
        name = ", ".join(filter(None, [*method, "…", settings]))
    return one_line(name)


def distinct(labels: Sequence[str]) -> list[str]:
    """Number labels that occur more than once.

    `["a", "b", "a"] -> ["a #1", "b", "a #2"]`.
    """
    shared = Counter(labels)
    names = []
    for label in labels:
        name = label
        if shared[label] > 1:
            numbered = (f"{label} #{number}" for number in count(1))
            name = next(text for text in numbered if text not in shared and text not in names)
        names.append(name)
    return names


_KEPT = 2  # items of a short name that a figure always shows: engine and formulation


def figure_names(labels: Names) -> dict[str, str]:
    """Map each solver to its name in a figure.

    `labels` maps each solver to its short name. The figure's name keeps engine and formulation. It
    leaves out items that all solvers of one engine and formulation share.
    """
    items = [label.split(", ") for label in labels.values()]
    names = []
    for parts in items:
        # An item is left out if all solvers with this engine and formulation have it.
        method = parts[:_KEPT]
        alike = [set(others) for others in items if others[:_KEPT] == method]
        distinctive = [item for item in parts[_KEPT:] if item not in set.intersection(*alike)]
        names.append(", ".join([*method, *distinctive]))
    return dict(zip(labels, names, strict=True))


_MOST_IN_PANEL = 44  # characters of a name beside a small panel
_USUAL_START = "bearing start"


def common_part(names: Sequence[str]) -> tuple[str, list[str]]:
    """The part that all names share, and shortened names.

    The shared part is for a title; it is empty if there is none. A name has engine, guess and
    settings, with commas between them: `["Ipopt, presolve", "SLSQP, presolve"] -> " (presolve)",
    ["Ipopt", "SLSQP"]`.
    """
    names = distinct([one_line(name, _MOST_IN_PANEL) for name in names])
    tails = {name.partition(", ")[2] for name in names}
    # An engine whose only guess is the usual one, or that needs none, does not name it: with
    # `Ipopt, bearing start` and `OSQP` the tail `bearing start` is shared.
    if tails > {_USUAL_START}:
        tails.discard("")
    all_share_a_tail = len(tails) == 1 and tails != {""}
    if len(names) < 2 or not all_share_a_tail:
        return "", names
    return f" ({tails.pop()})", [name.partition(", ")[0] for name in names]


def one_line(text: str, most: int = _MOST_CHARACTERS) -> str:
    """A text on one line, cut to `most` characters."""
    return shortened(" ".join(text.split()), most)


LineStyle = str | tuple[int, tuple[float, ...]]
LINES: tuple[LineStyle, ...] = ("-", (0, (4, 1.5)), (0, (1, 1.2)), (0, (5, 1.5, 1, 1.5)))
# Ten hues and eleven markers: their combinations repeat only after 110 engines.
_MARKERS = ("^", "s", "D", "v", "P", "X", "p", "*", "<", ">", "h")
_OWN = ("*", "P", "X", "h")  # of plug-ins' solvers, which have hues that no engine has
_OWN_HUES = (style.VERMILION, style.GREEN)
# Engines in the order in which they get hues and markers; those that meet in most figures come
# first, so that they differ in hue. Engines that the list does not name follow by name.
_ENGINES = (
    "Ipopt",
    "SLSQP",
    "fatrop",
    "Bonmin",
    "SLEQP",
    "trust-constr",
    "Uno",
    "Uno filterSQP",
    "casadi sqpmethod",
    "NLopt SLSQP",
    "APOPT",
    "COBYQA",
    "alpaqa",
    "casadi qrsqp",
    "NLopt AUGLAG",
    "NLopt COBYLA",
    "SCIP",
    "MAiNGO",
    "Clarabel",
    "MINPACK lm",
    "OSQP",
    "CMA-ES",
    "PIQP",
    "DIRECT",
    "MINPACK hybr",
    "Nelder-Mead",
    "Powell",
    "SHGO",
    "dual annealing",
    "HiGHS",
    "differential evolution",
    "SCS",
    "DAQP",
    "ECOS",
    "ProxQP",
    "QPALM",
)
_FORMULA = "closed form"
# A grey curve for comparison, behind those that have a colour and a name.
BEHIND: style.Style = {"color": style.RULE, "linewidth": 0.8, "zorder": 1.5}


class Look(NamedTuple):
    """How a solver is drawn."""

    colour: str
    marker: str
    line: LineStyle

    @property
    def dots(self) -> style.Style:
        """Keywords for markers without a line."""
        return {"color": self.colour, "marker": self.marker, "linestyle": "none"}

    @property
    def lines(self) -> style.Style:
        """Keywords for a line without markers."""
        return {"color": self.colour, "linestyle": self.line}


@dataclass(frozen=True)
class Palette:
    """The hue and the marker of each engine."""

    hues: dict[str, tuple[str, str]]  # engine -> colour and marker
    # spec -> its engine; a spec that is missing counts as an engine by its solver's name
    engines: Mapping[str, str] = field(default_factory=dict)
    labels: Names = field(default_factory=dict)  # spec -> its short name on the page

    @classmethod
    def of_page(cls, results: Results) -> Self:
        """The palette of all engines of a page.

        Solvers are looked up by their specs. Plug-ins' solvers get hues and markers of their own.
        """
        stated = names_of(results)["engine"]
        engines = {str(spec): parse_spec(str(engine))[0] for spec, engine in stated.items()}
        plugins = dict.fromkeys(filter(None, map(own_name, engines)))
        looks = zip(cycle(_OWN_HUES), cycle(_OWN), strict=False)
        hues = dict(zip(plugins, looks, strict=False))
        return cls(cls.of(engines.values()).hues | hues, engines, labels_of(results))

    @classmethod
    def of(cls, engines: Iterable[str]) -> Self:
        """A palette of engines, or of solvers' names.

        The closed form, the reference in every figure, gets the text's colour.
        """
        names = {parse_spec(engine)[0] for engine in engines} - {EXACT, _FORMULA}
        others = sorted(names - set(_ENGINES), key=natural)
        colours = cycle(hue.light for hue in style.ENGINE_HUES)
        looks = zip(colours, cycle(_MARKERS), strict=False)
        hues = dict(zip((*_ENGINES, *others), looks, strict=False))
        reference = (style.INK, "o")
        return cls({EXACT: reference, _FORMULA: reference} | hues)

    def looks(self, specs: Iterable[str]) -> dict[str, Look]:
        """Map each solver of a figure to its look.

        Solvers with the same hue get different line styles.
        """
        result: dict[str, Look] = {}
        used: dict[str, int] = {}
        # Hues that are alike in grey begin with other dashes.
        dashes = {hue.light: place for place, hue in enumerate(style.ENGINE_HUES)}
        for spec in solver_order(list(specs)):
            colour, marker = self.hues[self.engines.get(spec, parse_spec(spec)[0])]
            place = used.get(colour, -1) + 1  # the n-th solver of this hue, from 0
            used[colour] = place
            line = LINES[(dashes.get(colour, 0) + place) % len(LINES)]
            result[spec] = Look(colour, marker, line)
        return result

    def names(self, specs: Iterable[str]) -> dict[str, str]:
        """Map each solver to its name in a figure.

        A name has only the items of the short name that distinguish it (`figure_names`).
        """
        return figure_names({spec: self.label(spec) for spec in specs})

    def label(self, spec: str) -> str:
        """A solver's short name, or else its spec."""
        return self.labels.get(spec) or one_line(spec)
