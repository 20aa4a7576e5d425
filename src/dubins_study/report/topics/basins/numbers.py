"""The minima that local solvers reach on the joint model from given initial guesses.

The local minima of the paper's model (4.12) are known: RS, LS and LR, each with any number of full
turns added (docs/derivation.md, section 7). The length of an answer therefore identifies its
minimum.
"""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

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
