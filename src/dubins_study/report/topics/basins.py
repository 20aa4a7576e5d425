"""The minima that local solvers reach on the joint model from given initial guesses.

The local minima of the paper's model (4.12) are known: RS, LS and LR, each with any number of full
turns added (docs/derivation.md, section 7). The length of an answer therefore identifies its
minimum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, sentences, share, slug
from dubins_study.report.elements.names import names_of
from dubins_study.report.elements.plots import draw_cells
from dubins_study.report.elements.style import HALF, MAP_PAPER, ON_MAP, WIDE, new_figure
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import parse_spec, solver_order
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.rows.schema import SCENARIO, names
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances

OPTIMUM = "shortest path"
TURNS = "shortest path and full turns"
OTHER = "another local minimum"
FALSE_MINIMUM = "false minimum"
INFEASIBLE = "says that no path exists"
FALSE_PATH = "false path (misses the target)"
GIVES_UP = "gives up"
ENDS = (OPTIMUM, TURNS, OTHER, FALSE_MINIMUM, INFEASIBLE, FALSE_PATH, GIVES_UP)
REFUTED = (FALSE_MINIMUM, INFEASIBLE, FALSE_PATH)  # claims that the check refutes

_WORDS = ("LS", "RS", "LR")  # the joint model in the order LRS has no RL


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
    scenario = Scenario(**{name: row[name] for name in names(SCENARIO)})
    local_minimum = minimum(scenario, float(row["length"]))
    if local_minimum is None:
        return FALSE_MINIMUM, math.nan
    word, turns = local_minimum
    return (TURNS if word == row["reference_word"] and turns else OTHER), turns


def ends(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts that start from given lengths, with these lengths and the attempt's end.

    Adds the columns z1, z2, z3 (lengths of the guess in radii; for the turns z1 and z2 this is
    rad), end, turns (needless full turns; NaN if the end is not a minimum).
    """
    guessed = rows[~rows["initial_guess"].isin(["cold", "warm"]) & rows["solver"].notna()]
    if guessed.empty:
        return guessed.assign(z1=[], z2=[], z3=[], end=[], turns=[])
    points = guessed["initial_guess"].str.split(expand=True).astype(float)
    frame = guessed.assign(z1=points[0], z2=points[1], z3=points[2])
    frame[["end", "turns"]] = [end_of(row) for _, row in guessed.iterrows()]
    return frame.astype({"turns": float})


def is_capped(solver: str) -> bool:
    """Whether a spec bounds each turn by a full turn, which is the default."""
    return parse_spec(solver)[1].get("capped", "True").lower() == "true"


def capping(table: pd.DataFrame) -> pd.DataFrame:
    """The effect of a bound on turns, for the solvers of `shares` that ran with and without it.

    Index capped (False, True; empty if there is no such solver); columns optimal and turned (shares
    of the attempts that end in the shortest path, and in a minimum with full turns), refuted
    (number of claims).
    """
    both = table.groupby("name")["capped"].transform("nunique") == 2
    total = table[both].groupby("capped").sum(numeric_only=True)
    turned = total[["turns_1", "turns_2", "turns_more"]].sum(axis="columns")
    optimal, turned = total[OPTIMUM] / total["guesses"], turned / total["guesses"]
    return pd.DataFrame({"optimal": optimal, "turned": turned, "refuted": total["refuted"]})


def shares(table: pd.DataFrame) -> pd.DataFrame:
    """One row per scenario and solver, from `ends`.

    Columns: label, reference_word, solver, name (without settings), capped (whether each turn is
    bounded by a full turn), guesses (number of attempts), one count per end, optimal (share of
    guesses), turns_1, turns_2, turns_more (minima with 1, 2 or more needless full turns, of any
    word), most_turns, refuted (number of claims).
    """
    records = []
    for label, group in table.groupby("label", sort=True):
        for solver in solver_order(group["solver"].tolist()):
            attempts = group[group["solver"] == solver]
            counts = {end: int((attempts["end"] == end).sum()) for end in ENDS}
            word, turns = attempts["reference_word"].iloc[0], attempts["turns"].fillna(0)
            record = {"label": label, "reference_word": word, "solver": solver}
            record |= {"name": parse_spec(solver)[0], "capped": is_capped(solver)}
            record |= {"guesses": len(attempts), **counts}
            record |= {"optimal": counts[OPTIMUM] / len(attempts)}
            record |= {"turns_1": (turns == 1).sum(), "turns_2": (turns == 2).sum()}
            record |= {"turns_more": (turns > 2).sum(), "most_turns": int(turns.max())}
            records.append(record | {"refuted": sum(counts[end] for end in REFUTED)})
    return pd.DataFrame.from_records(records)


def extremes(table: pd.DataFrame) -> list[pd.Series[Any]]:
    """The extreme rows of `shares`.

    Returns:
        The rows with the least and the most shortest paths, with the most full turns in one path,
        and with the largest share of refuted claims.
    """
    optimal, refuted = table["optimal"].to_numpy(), (table["refuted"] / table["guesses"]).to_numpy()
    turns = table["most_turns"].to_numpy()
    places = optimal.argmin(), optimal.argmax(), turns.argmax(), refuted.argmax()
    return [table.iloc[int(place)] for place in places]


def turned_share(table: pd.DataFrame) -> float:
    """Share of all attempts in `shares` that end in a minimum with full turns."""
    turned = table[["turns_1", "turns_2", "turns_more"]].to_numpy().sum()
    return float(turned / table["guesses"].sum())


# From light to dark, so that grey print distinguishes the ends; refuted claims are marks on white.
_FILL = {
    OPTIMUM: "#d9ecdf",
    TURNS: "#6fb6dd",
    OTHER: "#d68a1c",
    FALSE_MINIMUM: MAP_PAPER,
    INFEASIBLE: MAP_PAPER,
    FALSE_PATH: MAP_PAPER,
    GIVES_UP: "#5d636b",
}
_MARK: dict[str, dict[str, Any]] = {
    TURNS: {"marker": ".", "markersize": 1.8},
    FALSE_MINIMUM: {"marker": "^", "markersize": 4, "markerfacecolor": "none"},
    INFEASIBLE: {"marker": "x", "markersize": 4},
    FALSE_PATH: {"marker": "s", "markersize": 3.5, "markerfacecolor": "none"},
    GIVES_UP: {"marker": "_", "markersize": 3, "color": MAP_PAPER},
}
_HATCH = {TURNS: "..."}  # in the legend, instead of marks
_TICKS = np.arange(5) * np.pi / 2
_TICK_TEXTS = ("0", "π/2", "π", "3π/2", "2π")


_DOTS: dict[str, Any] = {"linestyle": "none", "color": ON_MAP, "markeredgewidth": 0.7}


def plot_ends(ax: Axes, table: pd.DataFrame, title: str, listed: Sequence[str]) -> None:
    """Draw one solver's ends over the two turns of its guesses.

    Columns: z1, z2 (rad, on a grid), end. `title` is the panel's title; `listed` holds the ends
    that have marks.
    """
    codes = {end: float(i) for i, end in enumerate(ENDS)}
    grid = table.assign(code=table["end"].map(codes)).pivot_table(
        index="z2", columns="z1", values="code", aggfunc="first"
    )
    x, y = grid.columns.to_numpy(dtype=np.float64), grid.index.to_numpy(dtype=np.float64)
    draw_cells(ax, grid.to_numpy(dtype=np.float64), x, y, list(_FILL.values()))
    for end in listed:
        group = table[table["end"] == end]
        if end in _MARK and len(group):
            ax.plot(group["z1"], group["z2"], **_DOTS | _MARK[end])
    ax.set(xlabel="left turn of the guess (rad)", ylabel="right turn of the guess (rad)")
    ax.set_title(title, fontsize=8.5, fontweight="normal")
    ax.set_xticks(_TICKS, _TICK_TEXTS)
    ax.set_yticks(_TICKS, _TICK_TEXTS)


def legend_entries(listed: Sequence[str]) -> list[Artist]:
    """The legend's entries for some ends."""
    return [_entry(end) for end in listed]


def _entry(end: str) -> Artist:
    if end in _MARK and _FILL[end] == MAP_PAPER:
        return Line2D([], [], **_DOTS | _MARK[end], label=end)
    style: dict[str, Any] = {"hatch": _HATCH.get(end, ""), "edgecolor": ON_MAP, "linewidth": 0.4}
    return Patch(facecolor=_FILL[end], **style, label=end)


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
    present = [end for end in ENDS if (mapped["end"] == end).any()]
    names = _names(results, table["solver"].unique().tolist())
    pictures = [
        _picture(number, str(label), group, names, present)
        for number, (label, group) in enumerate(_groups(mapped), start=1)
    ]
    counts = shares(table)
    counts = counts.assign(called=counts["solver"].map(names))
    findings = _findings(shares(mapped).assign(called=lambda t: t["solver"].map(names)))
    text = sentences(_method(table), *findings, _cap(capping(counts)))
    lead = (
        "Every point of a map is an initial guess, its colour the path that a solver reaches from "
        "there: only the palest colour is the shortest path."
    )
    return Section("basins", "Where initial guesses lead", text, (*pictures, _table(counts)), lead)


_ACROSS = 3  # maps side by side
_MOST_LETTERS = 20  # of a solver's name above its map


def _names(results: Results, solvers: list[str]) -> dict[str, str]:
    """Solver -> its engine, which is enough of a name if only bounds on turns differ besides."""
    methods = names_of(results).loc[solvers]
    told_apart = methods.assign(capped=[is_capped(solver) for solver in solvers])
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
    least, most, farthest, worst = extremes(table)
    turned = turned_share(table)
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
            (INFEASIBLE, "that no path exists where one does"),
            (FALSE_MINIMUM, "that a point is a minimum, though no minimum has its length"),
            (FALSE_PATH, "that a path arrives, though it misses the target"),
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
        right = share((group["end"] == OPTIMUM).mean())
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
        *columns(count, **{TURNS: "with full turns", OTHER: "other minimum"}),
        *columns(count, turns_1="1 turn too many", turns_2="2", turns_more="more"),
        *columns(count, **{INFEASIBLE: "“no path”", FALSE_MINIMUM: "“minimum”"}),
        *columns(count, **{FALSE_PATH: "“path”", GIVES_UP: "gives up"}),
    )
    caption = (
        "Ends by solver and scenario. Turns too many are counted in minima of any word. In "
        "quotation marks what the solver says and the check refutes: that no path exists, that a "
        "point is a minimum, that a path arrives. A point that its solver does not call a solution "
        "counts as giving up, unless it is the shortest path."
    )
    marked = marks(table, *REFUTED)
    return Table("basins", caption, table, shown, marked, numbers=("solver",))


TOPIC = Topic("where initial guesses lead", basins_section, "basins")
