"""Minima that local solvers reach from given guesses.

The problem is the joint model. The local minima of the paper's model (4.12) are known: RS, LS and
LR, each with any number of full turns added (docs/derivation.md, section 7). The length of an
answer therefore identifies its minimum.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, Topic, panels_picture
from dubins_study.report.elements.formats import count, sentences, share, slug
from dubins_study.report.elements.looks import Names, names_of
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import MAP_PAPER
from dubins_study.report.statistics.metrics import parse_spec, solver_order
from dubins_study.report.topics.maps import kind_maps
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import scenario_of
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import DENIALS

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

# Refuted claim -> its content in words.
REFUTED = {
    INFEASIBLE: "that no path exists where one does",
    FALSE_MINIMUM: "that a point is a minimum, though no minimum has its length",
    FALSE_PATH: "that a path arrives, though it misses the target",
}
_QUARTER_TURNS = ("0", "π/2", "π", "3π/2", "2π")
_WORDS = ("LS", "RS", "LR")  # the joint model in the order LRS has no RL
_ACROSS = 3  # maps side by side
_MOST_LETTERS = 20  # of a solver's name above its map


def minimum(scenario: Scenario, length: float) -> tuple[str, int] | None:
    """The joint model's local minimum with this length.

    Returned are its word and its number of needless full turns, or None if no minimum has this
    length. Lengths count as equal within the check's gap tolerance times the shortest length.
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
    """Where one attempt ended, and its needless full turns.

    The first value is the key of one of `MARKS`. The second is NaN if the end is not a minimum. A
    shortest path that arrives counts as the optimum, whatever the claim. Columns of the row: the
    scenario, reference_word, claim, verdict, false_claim, length.
    """
    if row["verdict"] == "optimal":
        return OPTIMUM, 0
    if row["claim"] in DENIALS:
        return INFEASIBLE, math.nan
    if row["false_claim"]:
        return FALSE_PATH, math.nan
    if row["verdict"] != "longer" or row["claim"] not in ("optimal", "local"):
        return GIVES_UP, math.nan
    local_minimum = minimum(scenario_of(row), row["length"])
    if local_minimum is None:
        return FALSE_MINIMUM, math.nan
    word, turns = local_minimum
    if word == row["reference_word"] and turns:
        return TURNS, turns
    return OTHER, turns


def ends(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts from given guesses, with their ends.

    Attempts that began cold or warm are left out. Added are the columns z1, z2, z3 (lengths of the
    guess in radii; for the turns z1 and z2 this is rad), end (the key of one of `MARKS`) and turns
    (needless full turns; NaN if the end is not a minimum).
    """
    guessed = rows[~rows["initial_guess"].isin(["cold", "warm"])]
    points = guessed["initial_guess"].str.split(expand=True).reindex(columns=range(3))
    attempt_ends = [end_of(row) for row in guessed.to_dict("records")]
    end = pd.DataFrame(attempt_ends, guessed.index, ["end", "turns"])
    lengths = points.astype(float).set_axis(["z1", "z2", "z3"], axis="columns")
    return guessed.join(lengths).join(end.astype({"turns": float}))


def is_capped(solver: str) -> bool:
    """Whether a solver bounds each turn.

    The setting `capped` of its spec says so; the default is true. The bound is a full turn.
    """
    return parse_spec(solver)[1].get("capped", "True").lower() == "true"


def outcomes_of(table: pd.DataFrame) -> dict[str, float]:
    """Shares and counts over all attempts of a table.

    Keys: optimal (share of attempts that end at the optimum), turned (share with needless full
    turns), and refuted (the number of claims that the check refutes).
    """
    return {
        "optimal": (table["end"] == OPTIMUM).mean(),
        "turned": (table["turns"] > 0).mean(),
        "refuted": table["end"].isin(list(REFUTED)).sum(),
    }


def capping(table: pd.DataFrame) -> dict[bool, dict[str, float]]:
    """The outcomes without (key False) and with bounded turns.

    Only solvers that ran with both count. The result is empty if there is no such solver.
    """
    capped = table["solver"].map(is_capped)
    names = table["solver"].map(lambda spec: parse_spec(spec)[0])
    # solvers of one name that have attempts with the bound and without it
    with_both = table[capped.groupby(names).transform("nunique") == 2]
    return {bounded: outcomes_of(rows) for bounded, rows in with_both.groupby(capped)}


def basins_section(results: Results) -> Section | None:
    """The section on where initial guesses lead.

    It has a map for each scenario and solver. If solvers with unbounded turns were run, maps and
    most sentences show only these, since that is the paper's model.
    """
    table = ends(results.rows[results.rows["branch"] == "best"])
    if table.empty:
        return None
    mapped = table[~table["solver"].map(is_capped)]
    if mapped.empty:
        mapped = table
    names = _names(results, table["solver"].unique().tolist())
    straights = " and ".join(f"{z3:g}" for z3 in sorted(table["z3"].unique()))
    text = sentences(
        "Each solver gets the paper's unsplit model, L(z₁) R(z₂) S(z₃), with turns of any length. "
        "The initial guesses are a grid over z₁ and z₂; z₃ is "
        f"{straights} radii. Every local minimum of this model is LS, RS or LR with a number of "
        "full turns added, so its length identifies it.",
        _outcomes(mapped),
        _cap(capping(table)),
    )
    lead = (
        "Every point of a map is an initial guess. Its colour is the path that a solver reaches "
        "from there; the palest colour is the shortest path."
    )
    blocks = tuple(_pictures(mapped, names))
    return Section("basins", "Where initial guesses lead", text, blocks, lead)


def _names(results: Results, solvers: list[str]) -> dict[str, str]:
    """Map each solver to its name in the figures.

    The engine's name is enough unless two solvers have one engine and the same bound on turns.
    """
    methods = names_of(results).loc[solvers]
    with_bound = methods.assign(capped=[is_capped(solver) for solver in solvers])
    shared = with_bound.duplicated(["engine", "capped"], keep=False)
    names = methods["engine"].where(~shared, methods["label"])
    return {str(solver): str(name) for solver, name in names.items()}


def _outcomes(table: pd.DataFrame) -> str:
    """Sentences on the optima found and the claims refuted.

    The numbers are over all solvers.
    """
    outcomes = outcomes_of(table)
    most = table["turns"].fillna(0).max()
    refuted = "The check refutes no statement of a solver."
    if outcomes["refuted"]:
        numbers = table["end"].value_counts()
        parts = [f"{count(numbers[end])} times {REFUTED[end]}" for end in REFUTED if end in numbers]
        refuted = f"{count(outcomes['refuted'])} statements are refuted: {'; '.join(parts)}."
    return sentences(
        f"The shortest path is found from {share(outcomes['optimal'])} of the initial guesses; "
        f"{share(outcomes['turned'])} of all attempts end in a minimum with needless full turns, "
        f"up to {count(most)} of them. Nothing in the model forbids these.",
        refuted,
    )


def _cap(change: Mapping[bool, dict[str, float]]) -> str:
    """A sentence on what a bound on turns changes.

    `change` is the result of `capping`. The text is empty if no solver ran with the bound and
    without it.
    """
    if not change:
        return ""
    free = change[False]
    bounded = change[True]
    return (
        "From the same guesses, with every turn bounded by a full turn, "
        f"{share(bounded['turned'])} end with full turns instead of {share(free['turned'])}, and "
        f"{share(bounded['optimal'])} find the shortest path instead of {share(free['optimal'])}. "
        f"{count(bounded['refuted'])} statements are refuted instead of {count(free['refuted'])}."
    )


def _pictures(table: pd.DataFrame, names: Names) -> list[Picture]:
    """The maps of each scenario, one map per solver.

    A picture has at most `_ACROSS` maps side by side; further maps of the scenario follow in
    another picture.
    """
    order = solver_order(table["solver"].tolist())
    place = table["solver"].map(order.index)
    placed = table.assign(x=table["z1"], y=table["z2"], kind=table["end"], place=place)
    pictures = []
    # one picture for each scenario and each `_ACROSS` solvers
    figures = placed.groupby(["label", place // _ACROSS])
    for number, ((scenario, _), rows) in enumerate(figures, start=1):
        label = str(scenario)
        panels = {}
        for solver, group in rows.sort_values("place").groupby("solver", sort=False):
            right = share((group["end"] == OPTIMUM).mean())
            panels[f"{names[str(solver)][:_MOST_LETTERS]}: {right} shortest"] = group
        pictures.append(
            panels_picture(
                slug(f"basins-{number}-{label}"),
                f"{label[:1].upper()}{label[1:]}: where each of {count(len(rows) / len(panels))} "
                "initial guesses leads, one map per solver. White cells with a mark: statements "
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
    """Label the axes in quarters of a turn.

    The axes are the two turns of an initial guess.
    """
    ticks = np.arange(5) * np.pi / 2
    ax.set_xticks(ticks, _QUARTER_TURNS)
    ax.set_yticks(ticks, _QUARTER_TURNS)
    ax.set(xlabel="left turn of the guess (rad)", ylabel="right turn of the guess (rad)")


TOPIC = Topic("where initial guesses lead", basins_section, "basins")
