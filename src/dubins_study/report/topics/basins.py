"""The minima that local solvers reach on the joint model from given initial guesses.

The local minima of the paper's model (4.12) are known: RS, LS and LR, each with any number of full
turns added (docs/derivation.md, section 7). The length of an answer therefore identifies its
minimum.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, Topic, panels_picture
from dubins_study.report.elements.formats import count, sentences, share, slug
from dubins_study.report.elements.looks import names_of
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import MAP_PAPER
from dubins_study.report.statistics.metrics import by_solver, parse_spec, solver_order
from dubins_study.report.topics.maps import kind_maps
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
    Mark(TURNS, colour="#6fb6dd", marker="."),
    Mark(OTHER, colour="#d68a1c"),
    Mark(FALSE_MINIMUM, colour=MAP_PAPER, marker="^"),
    Mark(INFEASIBLE, colour=MAP_PAPER, marker="x"),
    Mark(FALSE_PATH, colour=MAP_PAPER, marker="s"),
    Mark(GIVES_UP, colour="#5d636b"),
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
_QUARTER_TURNS = ("0", "π/2", "π", "3π/2", "2π")
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


def end_of(row: Mapping[Hashable, Any]) -> tuple[str, float]:
    """How one attempt ended, and the number of needless full turns in its path.

    The number is NaN if the end is not a minimum. A shortest path that arrives counts as the
    optimum, with any claim. Columns: the scenario, reference_word, claim, verdict, false_claim,
    length.
    """
    if row["verdict"] == "optimal":
        return OPTIMUM, 0
    if row["false_claim"]:
        end = INFEASIBLE if row["claim"] == "infeasible" else FALSE_PATH
        return end, math.nan
    if row["verdict"] != "longer" or row["claim"] not in ("optimal", "local"):
        return GIVES_UP, math.nan
    local_minimum = minimum(scenario_of(row), row["length"])
    if local_minimum is None:
        return FALSE_MINIMUM, math.nan
    word, turns = local_minimum
    end = TURNS if word == row["reference_word"] and turns else OTHER
    return end, turns


def ends(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts that start from given lengths, with these lengths and the attempt's end.

    Adds the columns z1, z2, z3 (lengths of the guess in radii; for the turns z1 and z2 this is
    rad), end, turns (needless full turns; NaN if the end is not a minimum).
    """
    guessed = rows[~rows["initial_guess"].isin(["cold", "warm"])]
    points = guessed["initial_guess"].str.split(expand=True).reindex(columns=range(3))
    found = [end_of(row) for row in guessed.to_dict("records")]
    end = pd.DataFrame(found, guessed.index, ["end", "turns"])
    lengths = points.astype(float).set_axis(["z1", "z2", "z3"], axis="columns")
    return guessed.join(lengths).join(end.astype({"turns": float}))


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
    kinds |= {"turns_1": turns == 1, "turns_2": turns == 2, "turns_more": turns > 2}
    groups = table.assign(most_turns=turns, **kinds).groupby(["label", "solver"])
    frame = groups[list(kinds)].sum()
    frame["guesses"] = groups.size()
    frame["most_turns"] = groups["most_turns"].max()
    frame["optimal"] = frame[OPTIMUM] / frame["guesses"]
    frame["refuted"] = frame[list(REFUTED)].sum(axis="columns")
    frame = by_solver(frame.reset_index())
    frame["name"] = [parse_spec(solver)[0] for solver in frame["solver"]]
    frame["capped"] = frame["solver"].map(is_capped)
    return frame.sort_values("label", kind="stable", ignore_index=True)


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
    free = table[~table["solver"].map(is_capped)]
    mapped = table if free.empty else free
    names = _names(results, table["solver"].unique().tolist())
    counts = shares(table)
    counts["called"] = counts["solver"].map(names)
    straights = " and ".join(f"{z3:g}" for z3 in sorted(table["z3"].unique()))
    text = sentences(
        "Each solver is given the paper's model unsplit, L(z₁) R(z₂) S(z₃) with turns of any "
        "length, and one initial guess from a grid over z₁ and z₂; z₃ is "
        f"{straights} radii. Every local minimum of this model is LS, RS or LR with a number of "
        "full turns added, so an end is known by its length.",
        _found(counts[counts["solver"].isin(mapped["solver"])]),
        _cap(capping(counts)),
    )
    lead = (
        "Every point of a map is an initial guess, its colour the path that a solver reaches from "
        "there: only the palest colour is the shortest path."
    )
    shown = Table(
        "basins",
        "Ends by solver and scenario. Turns too many are counted in minima of any word. In "
        "quotation marks what the solver says and the check refutes: that no path exists, that a "
        "point is a minimum, that a path arrives. A point that its solver does not call a solution "
        "counts as giving up, unless it is the shortest path.",
        counts,
        COLUMNS,
        marks(counts, *REFUTED),
        numbers=("solver",),
    )
    blocks: tuple[Picture | Table, ...] = (*_pictures(mapped, names), shown)
    return Section("basins", "Where initial guesses lead", text, blocks, lead)


def _names(results: Results, solvers: list[str]) -> dict[str, str]:
    """Solver -> its engine, which is enough of a name if only bounds on turns differ besides."""
    methods = names_of(results).loc[solvers]
    told_apart = methods.assign(capped=[is_capped(solver) for solver in solvers])
    shared = told_apart.duplicated(["engine", "capped"], keep=False)
    names = methods["engine"].where(~shared, methods["label"])
    return {str(solver): str(name) for solver, name in names.items()}


def _found(table: pd.DataFrame) -> str:
    """How often the optimum is reached, and what the check refutes, over all solvers."""
    total = table.sum(numeric_only=True)
    turned = total[_TURNED].sum() / total["guesses"]
    refuted = "No solver said anything that the check refutes."
    if total["refuted"]:
        parts = [f"{count(total[end])} times {what}" for end, what in REFUTED.items() if total[end]]
        refuted = f"{count(total['refuted'])} statements are refuted: {'; '.join(parts)}."
    return sentences(
        f"The shortest path is found from {share(total[OPTIMUM] / total['guesses'])} of the "
        f"initial guesses; {share(turned)} of all attempts end in a minimum with full turns in it, "
        f"with up to {count(table['most_turns'].max())} of them: nothing in the model says that "
        "these are useless.",
        refuted,
    )


def _cap(change: pd.DataFrame) -> str:
    """What a bound on turns changes; empty if no solver ran with it and without it."""
    if change.empty:
        return ""
    free = change.loc[False]
    bounded = change.loc[True]
    return (
        "From the same initial guesses, but with every turn bounded by a full one, the share that "
        f"ends with full turns is {share(bounded['turned'])} instead of {share(free['turned'])}, "
        f"that of the shortest path {share(bounded['optimal'])} instead of "
        f"{share(free['optimal'])}, and the refuted statements number "
        f"{count(bounded['refuted'])} instead of {count(free['refuted'])}."
    )


def _pictures(table: pd.DataFrame, names: Mapping[str, str]) -> list[Picture]:
    """Each scenario's maps, a map per solver and at most `_ACROSS` side by side."""
    order = solver_order(table["solver"].tolist())
    place = table["solver"].map(order.index)
    placed = table.assign(x=table["z1"], y=table["z2"], kind=table["end"], place=place)
    pictures = []
    for number, (key, rows) in enumerate(placed.groupby(["label", place // _ACROSS]), start=1):
        label = str(key[0])
        panels = {}
        for solver, group in rows.sort_values("place").groupby("solver", sort=False):
            right = share((group["end"] == OPTIMUM).mean())
            panels[f"{names[str(solver)][:_MOST_LETTERS]}: {right} shortest"] = group
        pictures.append(
            panels_picture(
                slug(f"basins-{number}-{label}"),
                f"{label[:1].upper()}{label[1:]}: where each of {count(len(rows) / len(panels))} "
                "initial guesses leads, a map per solver. White cells with a mark are statements "
                "that the check refutes.",
                kind_maps,
                f"Maps of initial guesses by end, {label}",
                panels,
                MARKS,
                _dress,
                high=2.75,
            )
        )
    return pictures


def _dress(ax: Axes, _: pd.DataFrame) -> None:
    """The two turns of a guess, in quarters of a full one."""
    ticks = np.arange(5) * np.pi / 2
    ax.set_xticks(ticks, _QUARTER_TURNS)
    ax.set_yticks(ticks, _QUARTER_TURNS)
    ax.set(xlabel="left turn of the guess (rad)", ylabel="right turn of the guess (rad)")


TOPIC = Topic("where initial guesses lead", basins_section, "basins")
