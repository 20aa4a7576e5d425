"""The section on the minima that initial guesses lead to."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, sentences, share, slug
from dubins_study.report.statistics.metrics import parse_spec, solver_order
from dubins_study.report.topics.basins import numbers
from dubins_study.report.topics.basins.figures import plot_ends


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
    pictures = [
        _picture(label, solver, group, present)
        for solver in solver_order(mapped["solver"].tolist())
        for label, group in mapped[mapped["solver"] == solver].groupby("label", sort=True)
    ]
    table = numbers.shares(ends)
    findings = _findings(numbers.shares(mapped))
    text = sentences(_method(ends), *findings, _cap(numbers.capping(table)))
    return Section("basins", "Where initial guesses lead", text, (*pictures, _table(table)))


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
    return f"{parse_spec(row['solver'])[0]}, {row['label']}"


def _picture(label: object, solver: str, table: pd.DataFrame, shown: list[str]) -> Picture:
    title = f"{parse_spec(solver)[0]}, {label}"
    caption = (
        f"{title}: where each of {count(len(table))} initial guesses leads; in brackets how many. "
        "White cells with a mark are statements that the check refutes."
    )
    stem, alt = slug(f"basins-{label}-{solver}"), f"Map of initial guesses by end, {title}"
    data, height = (table, title, shown), 3.8 + 0.16 * len(shown)
    return picture(stem, plot_ends, *data, caption=caption, alt=alt, height=height, legend=1)


def _table(table: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="text", label="scenario"),
        *columns(kind="code", name="solver"),
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
    return Table("basins", caption, table, shown, marks(table, *numbers.REFUTED))
