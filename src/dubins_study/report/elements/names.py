"""Short names of solvers for figures and tables; a solver has one name on a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Section, Table
from dubins_study.report.statistics.methods import UNSTATED, methods_of
from dubins_study.study.words import FORMULATION_LIST

_FORMULATIONS = {formulation.name: formulation.short for formulation in FORMULATION_LIST}
_MOST_CHARACTERS = 70

_KNOWN: WeakKeyDictionary[Results, pd.DataFrame] = WeakKeyDictionary()


def names_of(results: Results) -> pd.DataFrame:
    """All methods of a page as `methods_of`, indexed by solver, also if `results` is a selection.

    The column `label` has their short names, e.g. `Ipopt, joint LRS, zero start`.
    """
    if results not in _KNOWN:
        methods = methods_of(results.methods)
        _KNOWN[results] = methods.assign(label=pd.Series(short_labels(methods), dtype=object))
    return _KNOWN[results]


def labels_of(results: Results) -> dict[str, str]:
    """Solver -> its short name on the page."""
    return {str(solver): str(label) for solver, label in names_of(results)["label"].items()}


def in_page_order(frame: pd.DataFrame, results: Results) -> pd.DataFrame:
    """The rows in the order of the page's solvers; rows of one solver keep their order."""
    place = {solver: number for number, solver in enumerate(names_of(results).index)}
    places = frame["solver"].map(place).fillna(len(place))
    return frame.loc[places.sort_values(kind="stable").index].reset_index(drop=True)


def short_labels(methods: pd.DataFrame) -> dict[str, str]:
    """Solver -> engine, formulation, initial guess, and the settings that differ; all distinct."""
    rows = methods.reset_index(names="solver").to_dict("records")
    return distinct([str(row["solver"]) for row in rows], [short_label(row) for row in rows])


def short_label(row: Mapping[Hashable, Any]) -> str:
    """The short name of a method (a row of `methods_of`), which another method may share."""
    formulation, engine = str(row["formulation"]), str(row["engine"])
    if engine == UNSTATED:
        return one_line(str(row["solver"]))
    where = "" if formulation == engine else _FORMULATIONS.get(formulation, formulation)
    settings = str(row["settings"]).split(", ")
    guess = str(row["variant"]).removesuffix(str(row["settings"])).removesuffix(", ")
    method = ", ".join(filter(None, [engine, where, guess]))
    # the settings of a long name that come last are those that a study varies
    texts = [", ".join(["…", *settings[number:]]) for number in range(1, len(settings))]
    names = [", ".join(filter(None, [method, text])) for text in [str(row["settings"]), *texts]]
    short_enough = (name for name in names if len(name) <= _MOST_CHARACTERS)
    return one_line(next(short_enough, names[0]))


def distinct(solvers: Sequence[str], labels: Sequence[str]) -> dict[str, str]:
    """Solver -> label; labels that several solvers share get a number."""
    shared = Counter(labels)
    taken = {label for label, number in shared.items() if number == 1}
    names = {}
    for solver, label in zip(solvers, labels, strict=True):
        name, number = label, 1
        while shared[label] > 1 and (number == 1 or name in taken):
            name, number = f"{label} #{number}", number + 1
        names[solver] = name
        taken.add(name)
    return names


_KEPT = 2  # items of a short name that a figure always shows: engine and formulation


def figure_names(labels: Mapping[str, str]) -> dict[str, str]:
    """Solver -> name for a figure: engine, formulation, and what else tells its solvers apart."""
    items = {solver: label.split(", ") for solver, label in labels.items()}
    groups: dict[tuple[str, ...], list[str]] = {}
    for solver, parts in items.items():
        groups.setdefault(tuple(parts[:_KEPT]), []).append(solver)
    names = {}
    for first, solvers in groups.items():
        common = set.intersection(*(set(items[solver]) for solver in solvers))
        for solver in solvers:
            rest = [item for item in items[solver][_KEPT:] if item not in common]
            names[solver] = ", ".join([*first, *rest])
    return {solver: names[solver] for solver in labels}


_MOST_IN_PANEL = 36  # characters of a name beside a small panel
_USUAL_START = "bearing start"


def common_part(names: Sequence[str]) -> tuple[str, list[str]]:
    """What all names but the engine share, for a title, e.g. ` (presolve)`; the names without it.

    A name has engine, guess and settings, with commas between them.
    """
    plain = [one_line(name, _MOST_IN_PANEL) for name in names]
    names = list(distinct([str(place) for place in range(len(plain))], plain).values())
    tails = {name.partition(", ")[2] for name in names}
    # An engine of which only the usual guess is known, or that needs none, does not name it.
    shared = tails - {""} if tails > {_USUAL_START} else tails
    if len(names) < 2 or len(shared) > 1 or shared == {""}:
        return "", names
    return f" ({shared.pop()})", [name.partition(", ")[0] for name in names]


def one_line(text: str, most: int = _MOST_CHARACTERS) -> str:
    """A text without line breaks, and with at most so many characters."""
    line = " ".join(text.split())
    return line if len(line) <= most else f"{line[: most - 1]}…"


def with_labels(section: Section, results: Results) -> Section:
    """The section, its tables with the short names of the page's solvers."""
    labels = labels_of(results)
    blocks = tuple(
        replace(block, labels=labels) if isinstance(block, Table) else block
        for block in section.blocks
    )
    return replace(section, blocks=blocks)
