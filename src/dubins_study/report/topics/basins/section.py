"""The section on the minima that initial guesses lead to."""

from __future__ import annotations

import math

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, sentences, share, slug
from dubins_study.report.elements.names import names_of
from dubins_study.report.elements.style import HALF, WIDE, new_figure
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.basins import numbers
from dubins_study.report.topics.basins.figures import legend_entries, plot_ends


def basins_section(results: Results) -> Section | None:
    """A map per scenario and solver, a table of ends, and sentences about them.

    If solvers with unbounded turns were run, maps and sentences show only these, since that is the
    paper's model; the table shows all solvers.
    """
    ends = numbers.ends(results.rows[results.rows["branch"] == "best"])
    if ends.empty:
        return None
    capped = ends["solver"].map(numbers.is_capped)
    mapped = ends if capped.all() else ends[~capped]
    present = [end for end in numbers.ENDS if (mapped["end"] == end).any()]
    names = _names(results, ends["solver"].unique().tolist())
    pictures = [
        _picture(number, str(label), group, names, present)
        for number, (label, group) in enumerate(_groups(mapped), start=1)
    ]
    table = numbers.shares(ends)
    table = table.assign(called=table["solver"].map(names))
    findings = _findings(numbers.shares(mapped).assign(called=lambda t: t["solver"].map(names)))
    text = sentences(_method(ends), *findings, _cap(numbers.capping(table)))
    lead = (
        "Every point of a map is an initial guess, its colour the path that a solver reaches from "
        "there: only the palest colour is the shortest path."
    )
    return Section("basins", "Where initial guesses lead", text, (*pictures, _table(table)), lead)


_ACROSS = 3  # maps side by side
_MOST_LETTERS = 20  # of a solver's name above its map


def _names(results: Results, solvers: list[str]) -> dict[str, str]:
    """Solver -> its engine, which is enough of a name if only bounds on turns differ besides."""
    methods = names_of(results).loc[solvers]
    told_apart = methods.assign(capped=[numbers.is_capped(solver) for solver in solvers])
    shared = told_apart.duplicated(["engine", "capped"], keep=False)
    return {str(k): str(v) for k, v in methods["engine"].where(~shared, methods["label"]).items()}


def _groups(mapped: pd.DataFrame) -> list[tuple[object, pd.DataFrame]]:
    """The attempts of each figure: one scenario, a few solvers."""
    solvers = solver_order(mapped["solver"].tolist())
    parts = [solvers[i : i + _ACROSS] for i in range(0, len(solvers), _ACROSS)]
    return [
        (label, group[group["solver"].isin(part)])
        for label, group in mapped.groupby("label", sort=True)
        for part in parts
        if group["solver"].isin(part).any()
    ]


def _method(table: pd.DataFrame) -> str:
    straights = " and ".join(f"{z3:g}" for z3 in sorted(table["z3"].unique()))
    return (
        "Each solver is given the paper's model unsplit, L(z₁) R(z₂) S(z₃) with turns of any "
        "length, and one initial guess from a grid over z₁ and z₂; z₃ is "
        f"{straights} radii. Every local minimum of this model is LS, RS or LR with a number of "
        "full turns added, so an end is known by its length."
    )


def _findings(table: pd.DataFrame) -> list[str]:
    """Three sentences: how often the optimum is reached, other minima, false claims."""
    least, most, farthest, worst = numbers.extremes(table)
    turned = numbers.turned_share(table)
    first = (
        f"The shortest path is found from {share(least['optimal'])} of the initial guesses at "
        f"worst ({_who(least)}) and from {share(most['optimal'])} at best "
        f"({_who(most)})."
    )
    second = f"{share(turned)} of all attempts end in a minimum with full turns in it"
    if turned:
        second += (
            f", with up to {count(farthest['most_turns'])} of them ({_who(farthest)}); "
            "nothing in the model says that these are useless"
        )
    refuted = int(table["refuted"].sum())
    if not refuted:
        return [first, f"{second}.", "No solver said anything that the check refutes."]
    parts = [
        f"{count(table[end].sum())} times {claim}"
        for end, claim in (
            (numbers.INFEASIBLE, "that no path exists where one does"),
            (numbers.FALSE_MINIMUM, "that a point is a minimum, though no minimum has its length"),
            (numbers.FALSE_PATH, "that a path arrives, though it misses the target"),
        )
        if table[end].sum()
    ]
    third = (
        f"{count(refuted)} statements are refuted: {'; '.join(parts)}. The worst is "
        f"{_who(worst)}, with {share(worst['refuted'] / worst['guesses'])} of its "
        "initial guesses."
    )
    return [first, f"{second}.", third]


def _cap(change: pd.DataFrame) -> str:
    if change.empty:
        return ""
    free, bounded = change.loc[False], change.loc[True]
    return (
        "From the same initial guesses, but with every turn bounded by a full one, the share that "
        f"ends with full turns is {share(bounded['turned'])} instead of {share(free['turned'])}, "
        f"that of the shortest path {share(bounded['optimal'])} instead of "
        f"{share(free['optimal'])}, and the refuted statements number "
        f"{count(bounded['refuted'])} instead of {count(free['refuted'])}."
    )


def _who(row: pd.Series) -> str:
    return f"{row['called']}, {row['label']}"


def _picture(
    number: int, label: str, table: pd.DataFrame, names: dict[str, str], shown: list[str]
) -> Picture:
    solvers = solver_order(table["solver"].tolist())
    figure = new_figure(WIDE if len(solvers) > 1 else HALF, 2.75 + 0.17 * math.ceil(len(shown) / 3))
    panels = figure.subplots(1, len(solvers), sharex=True, sharey=True, squeeze=False)[0]
    for ax, solver in zip(panels, solvers, strict=True):
        group = table[table["solver"] == solver]
        right = share((group["end"] == numbers.OPTIMUM).mean())
        plot_ends(ax, group, f"{names[solver][:_MOST_LETTERS]}: {right} shortest", shown)
        ax.label_outer()
    legend = {"handles": legend_entries(shown), "ncols": 3 if len(solvers) > 1 else 1}
    figure.legend(loc="outside lower left", fontsize=7.5, **legend)
    guesses = count(len(table) / len(solvers))
    caption = (
        f"{label[:1].upper()}{label[1:]}: where each of {guesses} initial guesses leads, a map per "
        "solver. White cells with a mark are statements that the check refutes."
    )
    stem = slug(f"basins-{number}-{label}")
    alt = f"Maps of initial guesses by end, {label}"
    return Picture(stem, caption, figure, alt, half=len(solvers) == 1)


def _table(table: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="text", label="scenario"),
        *columns(kind="text", called="engine"),
        *columns(lambda capped: "≤ 2π" if capped else "free", kind="text", capped="turns"),
        *columns(count, guesses="guesses"),
        *columns(share, optimal="shortest"),
        *columns(count, **{numbers.TURNS: "with full turns", numbers.OTHER: "other minimum"}),
        *columns(count, turns_1="1 turn too many", turns_2="2", turns_more="more"),
        *columns(count, **{numbers.INFEASIBLE: "“no path”", numbers.FALSE_MINIMUM: "“minimum”"}),
        *columns(count, **{numbers.FALSE_PATH: "“path”", numbers.GIVES_UP: "gives up"}),
    )
    caption = (
        "Ends by solver and scenario. Turns too many are counted in minima of any word. In "
        "quotation marks what the solver says and the check refutes: that no path exists, that a "
        "point is a minimum, that a path arrives. A point that its solver does not call a solution "
        "counts as giving up, unless it is the shortest path."
    )
    marked = marks(table, *numbers.REFUTED)
    return Table("basins", caption, table, shown, marked, numbers=("solver",))


TOPIC = Topic("where initial guesses lead", basins_section, "basins")
