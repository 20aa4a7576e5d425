"""Which method to use: a choice for each place of the target and each need, from the rows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.statistics.compared import Compared
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.study.path import FloatArray

# A method that meets a need on so many of the questions is sure enough to be chosen for its speed.
SURE = 0.99
# Times that differ by less are one: a machine's speed varies as much within a run.
AS_FAST = 1.1
# A method that was asked fewer of a region's questions met others than its rivals.
ENOUGH_ASKED = 0.9
LOOSE, TIGHT = 1e-4, 1e-8

# Margins in turning radii. Next to a circle the shortest length jumps; strata of the benchmark lie
# at 1e-3 and at 1e-1, so the bound lies between. Farther than `FAR` the first turn is short beside
# the straight part.
NEAR, FAR = 1e-2, 5.0
ANYWHERE = "anywhere"
REGIONS = {
    "far": f"outside, more than {FAR:g} R from both circles",
    "outside": "outside, nearer",
    "inside": "inside a circle",
    "near": f"within {NEAR:g} R of a circle",
}

# The columns that choices are made from: every selection of rows copies them.
_READ = [
    *("question", "branch", "solver", "region", "margin", "radius", "wall_s", "right"),
    *("gap", "miss", "length", "reference", "lower_bound", "false_bound", "false_claim"),
]


class Need(NamedTuple):
    """What a reader wants of an answer.

    Args:
        key: its name in files.
        title: its name on the page.
        accuracy: largest gap, as a share; below `LOOSE` also the largest miss, in radii.
        proof: whether the solver itself has to bound the gap by `accuracy`.
    """

    key: str
    title: str
    accuracy: float
    proof: bool


NEEDS = (
    Need("loose", "gap at most 1e-4", LOOSE, proof=False),
    Need("tight", "gap and miss at most 1e-8", TIGHT, proof=False),
    Need("loose_proof", "1e-4, proved by the solver", LOOSE, proof=True),
    Need("tight_proof", "1e-8, proved by the solver", TIGHT, proof=True),
)


class Choice(NamedTuple):
    """The method to use in one region for one need.

    Args:
        region: a key of `REGIONS`, or `ANYWHERE`.
        need: what is wanted.
        questions: how many the region has.
        methods: how many methods were compared.
        sure: how many of them meet the need on at least `SURE` of the questions.
        solver: the one to use; empty if none meets the need even once.
        share, low, high: how often it meets the need, with the ends of the 95 % interval.
        wall_s: its median time (s).
    """

    region: str
    need: Need
    questions: int
    methods: int
    sure: int
    solver: str = ""
    share: float = float("nan")
    low: float = float("nan")
    high: float = float("nan")
    wall_s: float = float("nan")


def choices(compared: Compared) -> list[Choice]:
    """A choice for every region that has questions, and anywhere, and for every need.

    Only the branch `best` counts, if it was asked. The closed form is left out.
    """
    rows = asked_rows(compared)
    engines = rows[rows["solver"] != EXACT]
    liars = false_provers(compared)
    return [
        _choice(part[~part["solver"].isin(liars)] if need.proof else part, region, need)
        for region, part in _parts(engines)
        for need in NEEDS
    ]


def choose(methods: pd.DataFrame) -> str:
    """The solver to use: the surest of the fastest that are sure, else the most surely right.

    Args:
        methods: indexed by solver: share, low (the end of its interval) and wall_s (s).
    Returns:
        Of the methods with a share of at least `SURE` and a time that is at most `AS_FAST` times
        the least of theirs the one with the largest share, then the least time; if there is none,
        the one with the largest `low`, then the least time; empty if no share is above 0.
    """
    sure = methods[methods["share"] >= SURE]
    if len(sure):
        fast = sure[~(sure["wall_s"] > AS_FAST * sure["wall_s"].min())]  # a time may be missing
        order = fast.sort_values(["share", "wall_s"], ascending=[False, True], kind="stable")
        return str(order.index[0])
    ever = methods[methods["share"] > 0]
    if ever.empty:
        return ""
    order = ever.sort_values(["low", "wall_s"], ascending=[False, True], kind="stable")
    return str(order.index[0])


def closed_form(compared: Compared) -> Choice | None:
    """How often the closed form is right, and its time; None if it was not asked."""
    rows = asked_rows(compared)
    exact = rows[rows["solver"] == EXACT]
    return None if exact.empty else _choice(exact, ANYWHERE, NEEDS[0])


def asked_rows(compared: Compared) -> pd.DataFrame:
    """Attempts at questions with a path: those of the branch `best`, or of all if it has none."""
    rows = compared.answerable[_READ]
    best = rows["branch"] == "best"
    rows = rows[best] if best.any() else rows
    return rows.assign(place=rows["question"].map(_places(rows)))


def false_provers(compared: Compared) -> list[str]:
    """Methods with a bound or a claim of optimality of which at least one is false."""
    rows = compared.rows
    wrong_claim = (rows["claim"] == "optimal") & _true(rows["false_claim"])
    solvers = rows.loc[wrong_claim | _true(rows["false_bound"]), "solver"].unique()
    return sorted(set(solvers) - {EXACT})


def met(rows: pd.DataFrame, need: Need) -> pd.Series[bool]:
    """Whether each attempt meets a need."""
    scale = np.maximum(_numbers(rows, "reference"), _numbers(rows, "radius"))
    within = rows["right"].to_numpy(bool, copy=True)
    if need.accuracy < LOOSE:
        miss = _numbers(rows, "miss") / _numbers(rows, "radius")
        within &= (np.abs(_numbers(rows, "gap")) <= need.accuracy) & (miss <= need.accuracy)
    if need.proof:
        unproved = (_numbers(rows, "length") - _numbers(rows, "lower_bound")) / scale
        false = _true(rows["false_bound"]) | _true(rows["false_claim"])
        within &= (unproved <= need.accuracy) & ~false.to_numpy(bool)
    return pd.Series(within, rows.index)


def _parts(rows: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    regions = [name for name in REGIONS if (rows["place"] == name).any()]
    if len(regions) != 1 and len(rows):
        yield ANYWHERE, rows
    for name in regions:
        yield name, rows[rows["place"] == name]


def _choice(rows: pd.DataFrame, region: str, need: Need) -> Choice:
    questions = int(rows["question"].nunique())
    judged = rows.assign(met=met(rows, need))
    shares = scenario_shares(judged, by=["solver"], success="met", scenario=["question"])
    methods = shares.join(rows.groupby("solver", observed=True)["wall_s"].median())
    methods = methods[methods["trials"] >= ENOUGH_ASKED * questions]
    sure = int((methods["share"] >= SURE).sum())
    solver = choose(methods)
    if not solver:
        return Choice(region, need, questions, len(methods), sure)
    numbers = methods.loc[[solver], ["share", "low", "high", "wall_s"]].to_numpy(float)[0]
    return Choice(region, need, questions, len(methods), sure, solver, *numbers.tolist())


def _places(rows: pd.DataFrame) -> pd.Series[str]:
    """Question -> the key of its region; missing where no attempt says where the target lies."""
    first = rows.groupby("question")[["region", "margin"]].first()
    margin = first["margin"].abs().to_numpy(np.float64, na_value=np.nan)
    known = np.isfinite(margin) & first["region"].notna().to_numpy()
    outside = (first["region"] == "outside").fillna(False).to_numpy(bool)
    conditions = [~known, margin <= NEAR, ~outside, margin > FAR]
    places = np.select(conditions, ["", "near", "inside", "far"], "outside")
    return pd.Series(places, first.index)


def _numbers(rows: pd.DataFrame, name: str) -> FloatArray:
    return rows[name].to_numpy(np.float64, na_value=np.nan)


def _true(values: pd.Series) -> pd.Series[bool]:
    return values.eq(True).fillna(False).astype(bool)
