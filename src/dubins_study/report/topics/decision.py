"""Which formulation to choose: a table of formulations.

The table says what each must know, how often it is right in each suite, and how its attempts end.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import (
    ENOUGH_ASKED,
    ENOUGH_TO_CHOOSE,
    EXACT,
    first_true,
    is_true,
    legs_of,
    own_name,
)
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns, marks
from dubins_study.report.elements.content import General, Place, Section, Table, Topic
from dubins_study.report.elements.formats import count, share, some
from dubins_study.report.elements.identity import with_interval
from dubins_study.report.elements.looks import labels_of
from dubins_study.report.statistics.methods import UNSTATED, Compared, by_support, compared
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.study.words import Outcome

TITLE = "Where engines err, and where they stop"
_KIND = ["formulation", "guesses"]
_NO_GUESS = ("none", "")
_MOST_LINES = 12  # with a reader's own solver: up to this many solvers have a line each
_SHARES = ("longer", "misses", "none", "late", "not asked")


_NEAR = 0.1  # radii from a turning circle


def suites(rows: pd.DataFrame) -> pd.Series[str]:
    """The suite of each row, by name.

    A suite is an experiment. An experiment with enough targets near a turning circle and elsewhere
    counts as two: the number of hard targets was chosen, so a share of all targets says nothing of
    the engine.
    """
    near = rows["margin"].abs() <= _NEAR * (1 + 1e-6)
    where = near.map({True: ", near a circle", False: ", elsewhere"})
    parts = rows["question"].groupby([rows["experiment"], near]).nunique().unstack(fill_value=0)
    enough = rows["experiment"].map(parts.min(axis=1)) >= ENOUGH_TO_CHOOSE
    several = rows["experiment"].map(parts.gt(0).sum(axis=1)) > 1
    return rows["experiment"].astype(str).str.cat(where.where(enough & several, ""))


def best_supported(rows: pd.DataFrame) -> pd.DataFrame:
    """The best-supported method of each line and experiment.

    A line of the table is a formulation with a kind of guess. Only methods asked more than half as
    often as the most asked one count, so that no sample wins. The lower end of the interval
    decides, then the median time. Indexed by experiment, formulation and guesses; columns solver,
    share, low, high, trials and wall_s (median).
    """
    keys = ["experiment", *_KIND]
    ranked = by_support(rows, [*keys, "solver"])
    asked = ranked["trials"].groupby(keys, observed=True).transform("max")
    whole = ranked[2 * ranked["trials"] > asked]
    return whole.reset_index("solver").groupby(keys, sort=False).head(1)


def ends(rows: pd.DataFrame) -> dict[Hashable, dict[Any, float]]:
    """Map each line to how its attempts ended.

    A line is (formulation, guesses), all engines together. Five values are shares of all attempts:
    longer, misses, none (no path), late (an answer after the limit) and not asked. Two are numbers:
    false_claims, and asked (attempts made).
    """
    was_asked = rows["outcome"] != Outcome.NOT_ASKED
    conditions = {
        "late": is_true(rows["late"]),
        "longer": rows["verdict"].eq("longer"),
        "misses": rows["verdict"].eq("misses"),
        "not asked": ~was_asked,
        "right": rows["right"],
    }
    # a right answer has no share here
    kinds_of_end = pd.get_dummies(first_true(conditions, "none"))
    flags = kinds_of_end.reindex(columns=_SHARES, fill_value=False)
    counted = pd.DataFrame({"false_claims": is_true(rows["false_claim"]), "asked": was_asked})
    kinds = [rows[key] for key in _KIND]
    return flags.groupby(kinds).mean().join(counted.groupby(kinds).sum()).to_dict("index")


def stops(rows: pd.DataFrame, strata: Sequence[str]) -> dict[Hashable, str]:
    """Map each line to the sizes that engines solve.

    A line is (formulation, guesses). Its text has a number of legs for each spacing, in the order
    of `strata`: `5, 3, 2`. It is the largest size up to which one engine is right on most routes of
    every size. The result is empty without routes.
    """
    routes = rows.assign(legs=legs_of(rows))
    routes = routes[routes["legs"].groupby(routes["experiment"]).transform("max") > 1]
    kinds = [*_KIND, "label"]
    sizes = routes.groupby([*kinds, "solver", "legs"], observed=True)
    enough = sizes["question"].nunique() > 1
    holds = (sizes["right"].mean() > 0.5) & enough
    holds = holds.groupby([*kinds, "solver"]).cummin()  # a larger size after one that fails is luck
    labels = [label for label in strata if label in set(routes["label"])]
    asked = enough[enough].groupby(kinds).size().unstack().reindex(columns=labels)
    most = holds[holds].reset_index().groupby(kinds)["legs"].max().unstack()
    largest = most.reindex(index=asked.index, columns=labels).fillna(0)
    texts = largest.map(count).where(asked.notna(), "–")
    return {kind: ", ".join(line) for kind, line in zip(texts.index, texts.to_numpy(), strict=True)}


def decision_section(results: Results) -> Section | None:
    """The section with the table of formulations.

    If there are no attempts to compare, a sentence says so. A plug-in's solver has a line of its
    own, before all others. Every solver has one if a suite has too few questions to choose the
    best-supported method of each formulation.
    """
    attempts = compared(results)
    if attempts is None or attempts.answerable.empty:
        return Section("decision", TITLE, "", (), "Nothing can be compared here.")
    rows = attempts.answerable
    # answers with more time than others to the same question are not compared; a reader's own
    # solver keeps its line, and the page warns of its other limit
    plugins = rows["solver"].map(own_name).ne("")
    least = rows["limit_s"].groupby(rows["question"]).transform("min")
    rows = rows[~(rows["limit_s"] > least) | plugins]
    plugins = plugins[rows.index]
    rows = rows.assign(experiment=suites(rows))
    # of an unfinished run no solver may have met enough questions, though together they have
    met = rows.groupby(["experiment", "solver"], observed=True)["question"].nunique()
    few = bool(met.groupby("experiment").max().min() < ENOUGH_TO_CHOOSE)
    each = few or bool(plugins.any() and len(attempts.methods) <= _MOST_LINES)
    stated = attempts.methods["formulation"].replace(UNSTATED, np.nan)
    formulation = rows["solver"].map(stated)
    alone = plugins | formulation.isna() | each
    rows = rows.assign(
        formulation=formulation.mask(alone, rows["solver"].map(labels_of(results))),
        guesses=rows["guesses"].fillna("").mask(alone, ""),
    )
    tables = (_table(attempts, rows, few=few, each=each),)
    text = "The table says what each method must know, and how often it is right."
    return Section("decision", TITLE, text, tables, _lead(rows))


def _lead(rows: pd.DataFrame) -> str:
    """A sentence that advises to use the closed form.

    It counts right answers only if the closed form was asked here.
    """
    exact = rows[rows["solver"] == EXACT]
    if exact.empty:
        return "If you only need the path, use the closed form."
    right = int(exact.groupby("question")["right"].min().sum())
    where = ""
    if legs_of(rows).gt(1).any():
        where = ", or the search with a proof where there are via points"
    return (
        f"If you only need the path, use the closed form{where}: right in time on "
        f"{count(right)} of {some(exact['question'].nunique(), 'question')} that are not open."
    )


def _table(attempts: Compared, rows: pd.DataFrame, *, few: bool, each: bool) -> Table:
    """The table of formulations and kinds of guesses.

    `few`: whether a suite has few questions. `each`: whether each solver has a line of its own.
    Plug-ins come first, then the lines that most suites ask.
    """
    # an engine at other options is asked a sample only, and would count twice
    equal = rows[rows["solver"].map(_equal)]
    # A line with engines at equal options counts these alone; another line counts all it has.
    stop = stops(rows, attempts.strata) | stops(equal, attempts.strata)
    ended = ends(rows) | ends(equal)
    first_seen = list(dict.fromkeys(rows["experiment"].str.partition(",")[0]))
    experiments = sorted(
        rows["experiment"].unique(),
        key=lambda name: (first_seen.index(name.partition(",")[0]), name),
    )
    best = _chosen(rows, experiments, each=each)
    lines = [
        _line(methods, ended[kind]) | {"stops": stop.get(kind, "")}
        for kind, methods in best.groupby(_KIND, sort=False)
    ]
    # `sure`: the mean of the lower ends of the intervals
    frame = pd.DataFrame(lines).sort_values(
        ["mine", "suites", "sure"], ascending=False, ignore_index=True
    )
    first_title = "formulation, guesses"
    if each:
        first_title = "method"
    shown = (
        *columns(kind="text", method=first_title, knows="knows"),
        *(Column(f"suite_{n}", name, kind="pick spec") for n, name in enumerate(experiments)),
        *columns(kind="cell", errs="longer / misses / none / unasked, %"),
        *columns(kind="cell", false="false claims", stops="legs"),
    )
    if not stop:
        shown = shown[:-1]
    caption = _caption(experiments, few=few, each=each, routes=bool(stop))
    numbers = ("formulation", "guesses", *_SHARES, "false_claims", "asked")
    bad = {(row, "false"): mark for (row, _), mark in marks(frame, "false_claims").items()}
    return Table("decision", caption, frame, shown, bad, numbers, stacked=True)


def _chosen(rows: pd.DataFrame, experiments: list[str], *, each: bool) -> pd.DataFrame:
    """The methods that the table shows, as in `best_supported`.

    Three columns are added: knows; place (of the experiment in `experiments`); sample (whether the
    method was asked a part of the questions only). Without `each`, a method of few questions is
    left out, unless it is a plug-in's.
    """
    best = best_supported(rows).reset_index()
    best = best[each | (best["trials"] >= ENOUGH_TO_CHOOSE) | best["solver"].map(own_name).ne("")]
    best["knows"] = best["solver"].map(rows.groupby("solver")["knows"].first())
    best["place"] = best["experiment"].map(experiments.index)
    most_asked = best.groupby("place")["trials"].transform("max")
    best["sample"] = best["trials"] < ENOUGH_ASKED * most_asked
    return best


def _caption(experiments: list[str], *, few: bool, each: bool, routes: bool) -> str:
    """The table's caption.

    `routes`: whether the table has the column of legs.
    """
    caption = "The share right with its 95 % interval (Wilson), then how the attempts end."
    if not each:
        caption = (
            "The best-supported solver, whose 95 % interval (Wilson) has the highest lower end. "
            "Of a number: asked a sample of that size. Then how the attempts of all "
            "engines end at equal options."
        )
    if few:
        caption += f" With fewer than {ENOUGH_TO_CHOOSE} questions every method has a line."
    caption += " None: no path in time. False claims: of attempts made."
    if any("circle" in name for name in experiments):
        caption += f" Near a circle: the target lies within {_NEAR:g} R of a turning circle."
    if routes:
        caption += (
            " Legs: the size up to which some engine is right on most routes, for each spacing, "
            "long to short; –: not asked."
        )
    return caption


def _equal(spec: str) -> bool:
    """Whether a solver has the options `equal`.

    A solver without this setting, such as a plug-in's, counts too.
    """
    return parse_spec(spec)[1].get("options", "equal") == "equal"


def _line(methods: pd.DataFrame, end: Mapping[Any, float]) -> dict[str, Any]:
    """One line of the table.

    `methods` has the line's best-supported method in each experiment, and `end` is how all its
    attempts ended.
    """
    first = methods.iloc[0]
    formulation = str(first["formulation"])
    guesses = str(first["guesses"])
    is_plugin = bool(own_name(first["solver"]))
    shares = (end["longer"], end["misses"], end["none"] + end["late"], end["not asked"])
    name = formulation
    if guesses not in _NO_GUESS:
        name += f", {guesses}"
    line: dict[str, Any] = {
        "formulation": formulation,
        "guesses": guesses,
        "method": name,
        "knows": " ".join(sorted(set(methods["knows"].str.cat(sep=" ").split()))),
        "mine": is_plugin,
        "suites": len(methods),
        "sure": methods["low"].mean(),
        "errs": " / ".join(f"{100 * part:.0f}" for part in shares),
        "false": f"{end['false_claims']:.0f} of {count(end['asked'])}",
        **end,
    }
    for method in methods.to_dict("records"):
        text = with_interval(share, method["share"], method["low"], method["high"])
        text = text.replace(" to ", "\u00a0to\u00a0")  # an interval stays on one line
        if method["sample"]:
            text += f" of {count(method['trials'])}"
        if not is_plugin:
            text = f"{method['solver']}\n{text}"
        line[f"suite_{method['place']}"] = text
    return line


TOPIC = Topic("where engines err", decision_section, General.DECIDED, place=Place.FRONT)
