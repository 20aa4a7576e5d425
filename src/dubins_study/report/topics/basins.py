"""The minima that local solvers reach on the joint model from given initial guesses.

The local minima of the paper's model (4.12) are known: RS, LS and LR, each with any number of full
turns added (docs/derivation.md, section 7). The length of an answer therefore identifies its
minimum.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, Topic, panels_picture
from dubins_study.report.elements.formats import count, sentences, share, slug
from dubins_study.report.elements.looks import names_of
from dubins_study.report.elements.plots import Mark, draw_cells
from dubins_study.report.elements.style import HALF, MAP_PAPER, ON_MAP, WIDE, Style, new_figure
from dubins_study.report.statistics.metrics import by_solver, parse_spec, solver_order
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import scenario_of
from dubins_study.study.tolerances import Tolerances

OPTIMUM = "shortest path"
TURNS = "shortest path and full turns"
OTHER = "another local minimum"
FALSE_MINIMUM = "false minimum"
INFEASIBLE = "says that no path exists"
FALSE_PATH = "false path (misses the target)"
GIVES_UP = "gives up"
# From light to dark, so that grey print distinguishes the ends; refuted claims are marks on white.
MARKS = (
    Mark(OPTIMUM, colour="#d9ecdf"),
    Mark(TURNS, colour="#6fb6dd", marker=".", hatch="..."),
    Mark(OTHER, colour="#d68a1c"),
    Mark(FALSE_MINIMUM, colour=MAP_PAPER, marker="^"),
    Mark(INFEASIBLE, colour=MAP_PAPER, marker="x"),
    Mark(FALSE_PATH, colour=MAP_PAPER, marker="s"),
    Mark(GIVES_UP, colour="#5d636b", marker="_"),
)
ENDS = tuple(mark.key for mark in MARKS)

COLUMNS = (
    *columns(kind="text", label="scenario"),
    *columns(kind="text", called="engine"),
    *columns(lambda capped: "≤ 2π" if capped else "free", kind="text", capped="turns"),
    *columns(count, guesses="guesses"),
    *columns(share, optimal="shortest"),
    *columns(count, **{TURNS: "with full turns", OTHER: "other minimum"}),
    *columns(count, turns_1="1 turn too many", turns_2="2", turns_more="more"),
    *columns(count, **{INFEASIBLE: "“no path”", FALSE_MINIMUM: "“minimum”"}),
    *columns(count, **{FALSE_PATH: "“path”", GIVES_UP: "gives up"}),
)
# Claim that the check refutes -> what it says.
REFUTED = {
    INFEASIBLE: "that no path exists where one does",
    FALSE_MINIMUM: "that a point is a minimum, though no minimum has its length",
    FALSE_PATH: "that a path arrives, though it misses the target",
}
_TURNED = ["turns_1", "turns_2", "turns_more"]
_WORDS = ("LS", "RS", "LR")  # the joint model in the order LRS has no RL
_ACROSS = 3  # maps side by side
_MOST_LETTERS = 20  # of a solver's name above its map


def minimum(scenario: Scenario, length: float) -> tuple[str, int] | None:
    """The local minimum of the joint model that has this length: word and full turns, or None.

    Lengths count as equal within the check's gap tolerance times the shortest length.
    """
    best = shortest(scenario)
    if best is None:
        return None
    tolerance = Tolerances().gap * max(best.total, 1.0)
    for word in _WORDS:
        path = shortest(scenario, word)
        if path is None:
            continue
        above = length / scenario.radius - path.total
        turns = max(0, round(above / math.tau))
        if abs(above - turns * math.tau) <= tolerance:
            return word, turns
    return None


def end_of(row: pd.Series) -> tuple[str, float]:
    """How one attempt ended, and the number of needless full turns in its path.

    The number is NaN if the end is not a minimum. A shortest path that arrives counts as the
    optimum, with any claim. Columns: the scenario, reference_word, claim, verdict, false_claim,
    length.
    """
    if row["verdict"] == "optimal":
        return OPTIMUM, 0
    if row["false_claim"]:
        return (INFEASIBLE if row["claim"] == "infeasible" else FALSE_PATH), math.nan
    if row["verdict"] != "longer" or row["claim"] not in ("optimal", "local"):
        return GIVES_UP, math.nan
    local_minimum = minimum(scenario_of(row.to_dict()), float(row["length"]))
    if local_minimum is None:
        return FALSE_MINIMUM, math.nan
    word, turns = local_minimum
    return (TURNS if word == row["reference_word"] and turns else OTHER), turns


def ends(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts that start from given lengths, with these lengths and the attempt's end.

    Adds the columns z1, z2, z3 (lengths of the guess in radii; for the turns z1 and z2 this is
    rad), end, turns (needless full turns; NaN if the end is not a minimum).
    """
    guessed = rows[~rows["initial_guess"].isin(["cold", "warm"])]
    if guessed.empty:
        return guessed.assign(z1=[], z2=[], z3=[], end=[], turns=[])
    points = guessed["initial_guess"].str.split(expand=True).astype(float)
    frame = guessed.assign(z1=points[0], z2=points[1], z3=points[2])
    frame[["end", "turns"]] = [end_of(row) for _, row in guessed.iterrows()]
    return frame.astype({"turns": float})


def is_capped(solver: str) -> bool:
    """Whether a spec bounds each turn by a full turn, which is the default."""
    return parse_spec(solver)[1].get("capped", "True").lower() == "true"


def shares(table: pd.DataFrame) -> pd.DataFrame:
    """One row per scenario and solver, from `ends`: the columns `COLUMNS` besides `called`.

    And solver, name (without settings), turns_1, turns_2, turns_more (minima with 1, 2 or more
    needless full turns, of any word), most_turns, refuted (number of claims).
    """
    turns = table["turns"].fillna(0)
    kinds = {end: table["end"] == end for end in ENDS}
    kinds |= dict(zip(_TURNED, (turns == 1, turns == 2, turns > 2), strict=True))
    groups = table.assign(most_turns=turns, **kinds).groupby(["label", "solver"])
    frame = groups[list(kinds)].sum().assign(guesses=groups.size())
    frame = by_solver(frame.assign(most_turns=groups["most_turns"].max()).reset_index())
    return frame.sort_values("label", kind="stable", ignore_index=True).assign(
        name=lambda rows: [parse_spec(solver)[0] for solver in rows["solver"]],
        capped=lambda rows: rows["solver"].map(is_capped),
        optimal=lambda rows: rows[OPTIMUM] / rows["guesses"],
        refuted=lambda rows: rows[[*REFUTED]].sum(axis="columns"),
    )


def capping(table: pd.DataFrame) -> pd.DataFrame:
    """The effect of a bound on turns, for the solvers of `shares` that ran with and without it.

    Index capped (False, True; empty if there is no such solver); columns optimal and turned (shares
    of the attempts that end in the shortest path, and in a minimum with full turns), refuted
    (number of claims).
    """
    both = table.groupby("name")["capped"].transform("nunique") == 2
    total = table[both].groupby("capped").sum(numeric_only=True)
    turned = total[_TURNED].sum(axis="columns") / total["guesses"]
    optimal = total[OPTIMUM] / total["guesses"]
    return pd.DataFrame({"optimal": optimal, "turned": turned, "refuted": total["refuted"]})


def basins_section(results: Results) -> Section | None:
    """A map per scenario and solver, a table of ends, and sentences about them.

    If solvers with unbounded turns were run, maps and sentences show only these, since that is the
    paper's model; the table shows all solvers.
    """
    table = ends(results.rows[results.rows["branch"] == "best"])
    if table.empty:
        return None
    capped = table["solver"].map(is_capped)
    mapped = table if capped.all() else table[~capped]
    present = [mark for mark in MARKS if (mapped["end"] == mark.key).any()]
    names = _names(results, table["solver"].unique().tolist())
    solvers = solver_order(mapped["solver"].tolist())
    drawn = [
        (str(label), rows)
        for label, group in mapped.groupby("label", sort=True)
        for first in range(0, len(solvers), _ACROSS)
        for rows in [group[group["solver"].isin(solvers[first : first + _ACROSS])]]
        if len(rows)
    ]
    pictures = [
        _picture(number, label, rows, names, present)
        for number, (label, rows) in enumerate(drawn, start=1)
    ]
    counts = shares(table).assign(called=lambda rows: rows["solver"].map(names))
    straights = " and ".join(f"{z3:g}" for z3 in sorted(table["z3"].unique()))
    text = sentences(
        "Each solver is given the paper's model unsplit, L(z₁) R(z₂) S(z₃) with turns of any "
        "length, and one initial guess from a grid over z₁ and z₂; z₃ is "
        f"{straights} radii. Every local minimum of this model is LS, RS or LR with a number of "
        "full turns added, so an end is known by its length.",
        _found(counts[counts["solver"].isin(solvers)]),
        _cap(capping(counts)),
    )
    lead = (
        "Every point of a map is an initial guess, its colour the path that a solver reaches from "
        "there: only the palest colour is the shortest path."
    )
    caption = (
        "Ends by solver and scenario. Turns too many are counted in minima of any word. In "
        "quotation marks what the solver says and the check refutes: that no path exists, that a "
        "point is a minimum, that a path arrives. A point that its solver does not call a solution "
        "counts as giving up, unless it is the shortest path."
    )
    shown = Table("basins", caption, counts, COLUMNS, marks(counts, *REFUTED), numbers=("solver",))
    return Section("basins", "Where initial guesses lead", text, (*pictures, shown), lead)


def _names(results: Results, solvers: list[str]) -> dict[str, str]:
    """Solver -> its engine, which is enough of a name if only bounds on turns differ besides."""
    methods = names_of(results).loc[solvers]
    told_apart = methods.assign(capped=[is_capped(solver) for solver in solvers])
    shared = told_apart.duplicated(["engine", "capped"], keep=False)
    return {str(k): str(v) for k, v in methods["engine"].where(~shared, methods["label"]).items()}


def _found(table: pd.DataFrame) -> str:
    """How often the optimum is reached, and what the check refutes, over all solvers."""
    guesses, refuted = table["guesses"].sum(), table["refuted"].sum()
    turned = table[_TURNED].to_numpy().sum() / guesses
    counts = {what: table[end].sum() for end, what in REFUTED.items()}
    parts = [f"{count(number)} times {what}" for what, number in counts.items() if number]
    return sentences(
        f"The shortest path is found from {share(table[OPTIMUM].sum() / guesses)} of the initial "
        f"guesses; {share(turned)} of all attempts end in a minimum with full turns in it, with up "
        f"to {count(table['most_turns'].max())} of them: nothing in the model says that these are "
        "useless.",
        f"{count(refuted)} statements are refuted: {'; '.join(parts)}."
        if refuted
        else "No solver said anything that the check refutes.",
    )


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


def _picture(
    number: int, label: str, table: pd.DataFrame, names: Mapping[str, str], listed: Sequence[Mark]
) -> Picture:
    """One scenario's maps, a map per solver; `listed` are the ends of all maps."""
    solvers = solver_order(table["solver"].tolist())
    caption = (
        f"{label[:1].upper()}{label[1:]}: where each of {count(len(table) / len(solvers))} initial "
        "guesses leads, a map per solver. White cells with a mark are statements that the check "
        "refutes."
    )
    name, alt = slug(f"basins-{number}-{label}"), f"Maps of initial guesses by end, {label}"
    data = table, solvers, names, listed
    if len(solvers) == 1:
        return Picture(name, caption, _maps(*data, narrow=True), alt, half=True)
    return panels_picture(name, caption, _maps, alt, *data)


def _maps(
    table: pd.DataFrame,
    solvers: Sequence[str],
    names: Mapping[str, str],
    listed: Sequence[Mark],
    *,
    narrow: bool,
) -> Figure:
    """The maps side by side, or `narrow` one below the other, and a legend."""
    down, across = (len(solvers), 1) if narrow else (1, len(solvers))
    entries_across = 1 if narrow else 3
    high = 2.75 * down + 0.17 * math.ceil(len(listed) / entries_across)
    figure = new_figure(HALF if narrow else WIDE, high)
    panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False).ravel()
    for ax, solver in zip(panels, solvers, strict=True):
        group = table[table["solver"] == solver]
        _draw_ends(ax, group, listed)
        right = share((group["end"] == OPTIMUM).mean())
        title = f"{names[solver][:_MOST_LETTERS]}: {right} shortest"
        ax.set_title(title, fontsize=8.5, fontweight="normal")
        ax.label_outer()
    entries = [
        Line2D([], [], label=mark.key, **_dots(mark))
        if mark.colour == MAP_PAPER
        else Patch(label=mark.key, **mark.bar() | {"edgecolor": ON_MAP, "linewidth": 0.4})
        for mark in listed
    ]
    below: Style = {"loc": "outside lower left", "fontsize": 7.5, "ncols": entries_across}
    figure.legend(handles=entries, **below)
    return figure


def _draw_ends(ax: Axes, table: pd.DataFrame, listed: Sequence[Mark]) -> None:
    """Draw one solver's ends over the two turns of its guesses: z1, z2 (rad, on a grid), end."""
    coded = table.assign(code=table["end"].map(ENDS.index).astype(float))
    grid = coded.pivot_table(index="z2", columns="z1", values="code", aggfunc="first")
    x, y = grid.columns.to_numpy(dtype=np.float64), grid.index.to_numpy(dtype=np.float64)
    draw_cells(ax, grid.to_numpy(dtype=np.float64), x, y, [mark.colour for mark in MARKS])
    for mark in listed:
        group = table[table["end"] == mark.key]
        if mark.marker and len(group):
            ax.plot(group["z1"], group["z2"], **_dots(mark))
    ax.set(xlabel="left turn of the guess (rad)", ylabel="right turn of the guess (rad)")
    ticks, texts = np.arange(5) * np.pi / 2, ("0", "π/2", "π", "3π/2", "2π")
    ax.set_xticks(ticks, texts)
    ax.set_yticks(ticks, texts)


def _dots(mark: Mark) -> Style:
    """Open marks on a map, without a line; the palest on the darkest cells."""
    colour = MAP_PAPER if mark.key == GIVES_UP else ON_MAP
    style: Style = {"linestyle": "none", "color": colour, "markerfacecolor": "none"}
    return style | {"marker": mark.marker, "markersize": 3.5, "markeredgewidth": 0.7}


TOPIC = Topic("where initial guesses lead", basins_section, "basins")
