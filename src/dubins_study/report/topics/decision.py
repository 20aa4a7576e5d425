"""The first section: which method to use, by the target's place, accuracy and need of proof."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT, is_true
from dubins_study.report.data.command import run_command
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import General, Place, Section, Table, Topic
from dubins_study.report.elements.formats import count, seconds, sentences, share, some
from dubins_study.report.elements.identity import with_interval
from dubins_study.report.elements.looks import labels_of
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import Compared, compared
from dubins_study.report.topics.comparison import ENOUGH_ASKED

# A method is sure enough to be chosen for its speed if the lower end of the interval of the share
# at which it meets the need is at least this.
SURE = 0.99
# Times that differ by less are one: a machine's speed varies as much within a run.
AS_FAST = 1.1
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
    *("tolerance", "proves"),
]


class Need(NamedTuple):
    """What a reader wants of an answer, with its name in files and on the page.

    `accuracy` is the largest gap, as a share; below `LOOSE` also the largest miss, in radii. With
    `proof` the solver itself has to bound the gap by it.
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
    """The method to use in one region (a key of `REGIONS`, or `ANYWHERE`) for one need.

    Of the solver to use, empty if none meets the need even once: how often it does, with the ends
    of the 95 % interval, and its median time.
    """

    region: str
    need: Need
    questions: int
    methods: int  # that were compared
    solver: str = ""
    share: float = float("nan")
    low: float = float("nan")
    high: float = float("nan")
    wall_s: float = float("nan")


def choices(compared: Compared) -> list[Choice]:
    """A choice for every region that has questions, and anywhere, and for every need.

    Only the branch `best` counts, if it was asked. The closed form is left out, and so is a need
    that the settings exclude.
    """
    rows = asked_rows(compared)
    engines = rows[rows["solver"] != EXACT]
    liars = false_provers(compared)
    places = [name for name in REGIONS if (engines["place"] == name).any()]
    regions = {name: engines[engines["place"] == name] for name in places}
    if len(places) != 1 and len(engines):
        regions = {ANYWHERE: engines} | regions
    return [
        _choice(part[~part["solver"].isin(liars)] if need.proof else part, region, need)
        for region, part in regions.items()
        for need in possible_needs(engines)
    ]


def possible_needs(rows: pd.DataFrame) -> list[Need]:
    """The needs that the settings of the attempts allow.

    A proof that no attempt with a bound could reach is not asked for. A solver that does not say
    what it proves can prove no gap below twice the tolerance of its engine's equations.
    """
    bounded = rows[rows["lower_bound"].notna()]
    finest = bounded["proves"].astype(np.float64).fillna(2 * bounded["tolerance"]).min()
    return [need for need in NEEDS if not (need.proof and need.accuracy < finest)]


def choose(methods: pd.DataFrame) -> str:
    """The solver to use: the surest of the fastest that are sure, else the most surely right.

    Of the methods whose share has an interval that ends at or above `SURE` at its lower end, and
    whose time is at most `AS_FAST` times the least of theirs, the one with the largest share, then
    the least time; if there is none, the one with the largest `low`, then the least time; empty if
    no share is above 0.
    """
    sure = methods[methods["low"] >= SURE]
    fast = sure[~(sure["wall_s"] > AS_FAST * sure["wall_s"].min())]  # a time may be missing
    kept, key = (fast, "share") if len(fast) else (methods[methods["share"] > 0], "low")
    order = kept.sort_values([key, "wall_s"], ascending=[False, True], kind="stable")
    return str(order.index[0]) if len(order) else ""


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
    wrong_claim = (rows["claim"] == "optimal") & is_true(rows["false_claim"])
    solvers = rows.loc[wrong_claim | is_true(rows["false_bound"]), "solver"].unique()
    return sorted(set(solvers) - {EXACT})


def met(rows: pd.DataFrame, need: Need) -> pd.Series[bool]:
    """Whether each attempt meets a need."""
    names = ["gap", "miss", "length", "lower_bound", "reference", "radius"]
    numbers = rows[names].astype(np.float64)
    within = rows["right"].astype(bool)
    if need.accuracy < LOOSE:
        miss = numbers["miss"] / numbers["radius"]
        within = within & (numbers["gap"].abs() <= need.accuracy) & (miss <= need.accuracy)
    if need.proof:
        scale = np.maximum(numbers["reference"], numbers["radius"])
        unproved: pd.Series[float] = (numbers["length"] - numbers["lower_bound"]) / scale
        false = is_true(rows["false_bound"]) | is_true(rows["false_claim"])
        within = within & (unproved <= need.accuracy) & ~false
    return within


def _choice(rows: pd.DataFrame, region: str, need: Need) -> Choice:
    questions = int(rows["question"].nunique())
    judged = rows.assign(met=met(rows, need))
    shares = scenario_shares(judged, by=["solver"], success="met", scenario=["question"])
    methods = shares.join(rows.groupby("solver", observed=True)["wall_s"].median())
    methods = methods[methods["trials"] >= ENOUGH_ASKED * questions]
    solver = choose(methods)
    if not solver:
        return Choice(region, need, questions, len(methods))
    numbers = methods.loc[[solver], ["share", "low", "high", "wall_s"]].to_numpy(float)[0]
    return Choice(region, need, questions, len(methods), solver, *numbers.tolist())


def _places(rows: pd.DataFrame) -> pd.Series[str]:
    """Question -> the key of its region; missing where no attempt says where the target lies."""
    first = rows.groupby("question")[["region", "margin"]].first()
    margin = first["margin"].abs().to_numpy(np.float64, na_value=np.nan)
    known = np.isfinite(margin) & first["region"].notna().to_numpy()
    outside = (first["region"] == "outside").fillna(False).to_numpy(bool)
    conditions = [~known, margin <= NEAR, ~outside, margin > FAR]
    places = np.select(conditions, ["", "near", "inside", "far"], "outside")
    return pd.Series(places, first.index)


def cases_table(results: Results) -> Table:
    """One line for each kind of reader: the command of their own case, and the next section."""
    run = run_command(results.folders[0].manifest, "--solver FILE.py:CLASS --out MINE")
    lines = [
        (
            "You plan paths for a vehicle.",
            "Take the closed form; from Python it is dubins_study.solve. X and Y are the target, "
            "and --radius sets R.",
            "dubins-study solve X Y --from X0 Y0 HEADING",
            "Explore the problem",
        ),
        (
            "You have another problem, without a formula.",
            "Do not take over what needs the formula's words or its geometry (one NLP a word, the "
            "presolve); try several guesses, and check what the engine claims.",
            "dubins-study solvers",
            "Formulation by engine",
        ),
        (
            "You write a solver.",
            "Have it checked, then asked the questions of this page; the report of both folders "
            "has it beside the others.",
            f"dubins-study check-solver FILE.py:CLASS\n{run}\ndubins-study report FOLDER MINE",
            "Single attempts",
        ),
        (
            "You read the paper and want its errors.",
            "Every printed number beside the exact one.",
            "dubins-study audit",
            "The audit of the paper",
        ),
    ]
    frame = pd.DataFrame(lines, columns=["reader", "advice", "command", "section"])
    shown = (
        *columns(kind="text", reader="and in your case?"),
        *columns(kind="prose", advice="what to do"),
        *columns(kind="code", command="command"),
        *columns(kind="section", section="read on"),
    )
    caption = (
        "Words in capitals are yours to fill in: FILE.py:CLASS is your solver's file and class, "
        "FOLDER the results folder of this page. An angle may carry its unit: 120deg."
    )
    return Table("cases", caption, frame, shown, stacked=True)


TITLE = "What to use"
_USABLE = 0.5  # a method that fails more often than not is none to use
_NUMBERS = ("solver", "share", "low", "high", "wall_s")


def decision_section(results: Results) -> Section | None:
    """A table of choices; without attempts to choose from, a sentence that says so.

    Only a question of one leg with a free final heading has a region.
    """
    plain = results.rows[["via_x", "final_heading"]].isna().all(axis="columns")
    if not plain.all():
        if not plain.any():
            return None
        results = replace(results, rows=results.rows[plain])
    attempts = compared(results)
    if attempts is None:
        text = (
            "These rows hold no attempt by which solvers can be compared: each began from another "
            "solver's path, or its engine was not installed or cannot read the question."
        )
        return Section("decision", TITLE, text, (), "Nothing can be recommended here.")
    found, exact = choices(attempts), closed_form(attempts)
    liars = false_provers(attempts)
    text = sentences(
        ""
        if exact
        else "The closed form was not asked here, so that its time is not known; the check "
        "compares every answer with it all the same.",
        "Only one method was asked: the table shows how it does, and leaves no choice."
        if found and max(choice.methods for choice in found) == 1
        else "",
        f"{some(len(liars), 'method')} with a false proof at any question "
        f"{'is' if len(liars) == 1 else 'are'} left out where a proof is needed."
        if liars
        else "",
    )
    if not found:
        return Section("decision", TITLE, text, (), f"{_baseline(exact)}; no engine was asked.")
    tables = _table(found, labels_of(results)), cases_table(results)
    return Section("decision", TITLE, text, tables, f"{_baseline(exact)}; {_advice(found)}")


def _baseline(exact: Choice | None) -> str:
    """The closed form is always there to be used; here it may not have been asked."""
    if exact is None:
        return "If you only need the path, use the closed form"
    if not exact.solver:
        return f"The closed form, the baseline, is right on none of {exact.questions} questions"
    return (
        f"If you only need the path, use the closed form (right on {_success(exact)} of "
        f"{some(exact.questions, 'question')}, {seconds(exact.wall_s)} in the median)"
    )


def _advice(found: Sequence[Choice]) -> str:
    if not any(choice.solver for choice in found):
        return "no other method was right on any question, so that none can be recommended."
    return (
        "for another method, find the line of your target and the column of your need. Methods on "
        "one NLP a word, and those with the presolve, know the words of the answer: a problem "
        "without them is another."
    )


def _table(found: Sequence[Choice], labels: dict[str, str]) -> Table:
    by_region: dict[str, dict[str, Choice]] = {}
    for choice in found:
        by_region.setdefault(choice.region, {})[choice.need.key] = choice
    lines = [_line(region, row, labels) for region, row in by_region.items()]
    united = _united([*by_region.values()])
    marks = {
        (place, f"{needs[0].key}_pick"): "note"
        for place, row in enumerate(by_region.values())
        for needs in united
        if not row[needs[0].key].low >= SURE
    }
    shown = (
        *columns(kind="text", where="target"),
        *(
            Column(f"{needs[0].key}_pick", "; ".join(need.title for need in needs), kind="pick")
            for needs in united
        ),
    )
    keys = [need.key for needs in united for need in needs]
    numbers = ("region", "questions", *keys, *(f"{k}_{name}" for k in keys for name in _NUMBERS))
    sure = f"{100 * SURE:g} %"
    caption = (
        "The method to use, the share of the questions at which it meets the need (95 % interval, "
        "Wilson), its median time, and the spec to type: the fastest that meets the "
        f"need on at least {sure}, by the lower end of its interval. Grey: no method does; the "
        "best one is shown. In brackets: the number of questions, of which the "
        "choice was made too, which flatters it."
    )
    return Table("decision", caption, pd.DataFrame(lines), shown, marks, numbers, stacked=True)


def _united(rows: Sequence[dict[str, Choice]]) -> list[list[Need]]:
    """The needs, side by side; those with the same solvers and numbers share a column."""
    united: list[list[Need]] = []
    for key, choice in rows[0].items():
        before = united[-1][-1].key if united else ""
        if before and all(row[key][-5:] == row[before][-5:] for row in rows):
            united[-1].append(choice.need)
        else:
            united.append([choice.need])
    return united


def _line(region: str, row: dict[str, Choice], labels: dict[str, str]) -> dict[str, Any]:
    questions = next(iter(row.values())).questions
    place = ANYWHERE if region == ANYWHERE else REGIONS[region]
    line: dict[str, Any] = {"where": f"{place} ({count(questions)})", "region": region}
    line["questions"] = questions
    for key, choice in row.items():
        line[key] = _cell(choice, labels)
        line[f"{key}_pick"] = "\n".join(filter(None, (line[key], choice.solver)))
        line |= {f"{key}_{name}": getattr(choice, name) for name in _NUMBERS}
    return line


def _cell(choice: Choice, labels: dict[str, str]) -> str:
    if not choice.solver:
        return "none" if choice.methods else "none asked"
    label = labels.get(choice.solver, choice.solver)
    numbers = f"{_success(choice)}, {seconds(choice.wall_s)}".replace(" ", "\u00a0")
    numbers = numbers.replace(",\u00a0", ", ").replace("\u00a0(", " (")
    if choice.share < _USABLE:
        return f"none\nat best {label}: {numbers}"
    return f"{label}\n{numbers}"


def _success(choice: Choice) -> str:
    return with_interval(share, choice.share, choice.low, choice.high)


TOPIC = Topic("what to use", decision_section, General.DECIDED, place=Place.FRONT)
