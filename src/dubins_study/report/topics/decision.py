"""Where engines err and where they stop: formulation by formulation, suite by suite."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, EXACT, is_true, legs_of, own_name
from dubins_study.report.data.command import run_command
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns, marks
from dubins_study.report.elements.content import General, Place, Section, Table, Topic
from dubins_study.report.elements.formats import count, sentences, share, some
from dubins_study.report.elements.identity import best_first, with_interval
from dubins_study.report.elements.looks import labels_of
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import UNSTATED, Compared, compared
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.study.words import Outcome

TITLE = "Where engines err, and where they stop"
_KIND = ["formulation", "guesses"]
_NO_GUESS = ("none", "")
_MOST_LINES = 12  # solvers beside a reader's own, up to which each has a line
_ENDS = ("longer", "misses", "none", "late", "not asked", "false_claims", "asked")
_NUMBERS = ("solver", "share", "share_low", "share_high", "wall_s")


def surest(rows: pd.DataFrame) -> pd.DataFrame:
    """Of each formulation, its guesses and each experiment, the method that is most surely right.

    Of those asked more than half as often as any, so that no sample displaces the whole: the lower
    end of the interval decides, then the median time. Indexed by experiment, formulation and
    guesses; columns solver, share, low, high, trials and wall_s (median).
    """
    keys = ["experiment", *_KIND, "solver"]
    shares = scenario_shares(rows, by=keys, success="right", scenario=["question"])
    shares = shares.assign(wall_s=rows.groupby(keys, observed=True)["wall_s"].median())
    asked = shares["trials"].groupby(keys[:-1], observed=True).transform("max")
    whole = shares[2 * shares["trials"] > asked]
    ranked = whole.sort_values(["low", "wall_s"], ascending=[False, True], kind="stable")
    found = ranked.reset_index().drop_duplicates(keys[:-1]).set_index(keys[:-1])
    return found[["solver", "share", "low", "high", "trials", "wall_s"]]


def ends(rows: pd.DataFrame) -> dict[tuple[str, str], dict[str, float]]:
    """How the attempts of each formulation and kind of guess ended, all engines together.

    By formulation and guesses. Shares of all questions: longer, misses, none (no path), late (an
    answer after the limit) and not asked. Numbers: false_claims, and asked, the attempts made.
    """
    verdict, late = rows["verdict"], is_true(rows["late"])
    flags = {word: (verdict == word) & ~late for word in ("longer", "misses")}
    made = rows["outcome"] != Outcome.NOT_ASKED
    flags |= {"late": late, "not asked": ~made}
    flags |= {"none": ~(rows["right"] | pd.DataFrame(flags).any(axis="columns"))}
    counted = pd.DataFrame({"false_claims": is_true(rows["false_claim"]), "asked": made})
    kinds = [rows[key] for key in _KIND]
    frame = pd.DataFrame(flags).groupby(kinds).mean().join(counted.groupby(kinds).sum())
    ended: dict[tuple[str, str], dict[str, float]]
    ended = frame.to_dict("index")  # type: ignore[assignment]
    return ended


def stops(rows: pd.DataFrame, strata: Sequence[str]) -> dict[tuple[str, str], str]:
    """Up to how many legs an engine is right on most routes of every size, spacing by spacing.

    By formulation and guesses; empty without routes. A spacing is one of the `strata`.
    """
    legs = legs_of(rows)
    routes = rows.assign(legs=legs)
    routes = routes[routes["experiment"].isin(routes.loc[legs > 1, "experiment"])]
    labels = [label for label in strata if label in set(routes["label"])]
    keys = [*_KIND, "label", "solver"]
    holds = routes.groupby([*keys, "legs"], observed=True)["right"].mean() > 0.5
    holds = holds.groupby(keys).cummin()  # a larger size after one that fails is luck
    most = holds[holds].reset_index().groupby([*_KIND, "label"])["legs"].max()
    found = most.unstack("label").reindex(columns=labels)
    return {
        (str(kind[0]), str(kind[1])): ", ".join(count(n) if n == n else "0" for n in line)
        for kind, line in zip(found.index, found.to_numpy(), strict=True)
    }


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
            f"dubins-study check-solver FILE.py:CLASS\n{run}\n"
            "dubins-study report FOLDER MINE --out PAGE",
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
        "FOLDER the results folder of this page, PAGE a new folder. An angle may carry its unit: "
        "120deg."
    )
    return Table("cases", caption, frame, shown, stacked=True)


def decision_section(results: Results) -> Section | None:
    """A table of formulations; without attempts to compare, a sentence that says so.

    A plug-in's solver has a line of its own, before all others. Every solver has one if a suite has
    too few questions to choose the surest of each formulation.
    """
    attempts = compared(results)
    if attempts is None:
        text = (
            "These rows hold no attempt by which solvers can be compared: each began from another "
            "solver's path, or its engine was not installed or cannot read the question."
        )
        return Section("decision", TITLE, text, (), "Nothing can be compared here.")
    rows = attempts.answerable
    stated = attempts.methods["formulation"].replace(UNSTATED, np.nan)
    labels, questions = labels_of(results), rows.groupby("experiment")["question"].nunique()
    few = questions.min() < ENOUGH_TO_CHOOSE
    mine = rows["solver"].map(own_name).ne("")
    each = few or (bool(mine.any()) and len(attempts.methods) <= _MOST_LINES)
    formulation = rows["solver"].map(stated)
    alone = mine | formulation.isna() | each
    rows = rows.assign(
        formulation=formulation.mask(alone, rows["solver"].map(labels)),
        guesses=rows["guesses"].fillna("").mask(alone, ""),
    )
    if rows.empty:
        return Section("decision", TITLE, "", (), "No question that was asked has a path.")
    engines = attempts.engines
    text = sentences(
        "" if EXACT in attempts.methods.index else "The closed form was not asked here.",
        "Only one method was asked: the table leaves no choice." if len(engines) == 1 else "",
        "No engine was right on any question."
        if len(engines) and not rows.loc[rows["solver"] != EXACT, "right"].any()
        else "",
    )
    tables = *_tables(attempts, rows, labels, few=few, each=each), cases_table(results)
    return Section("decision", TITLE, text, tables, _lead(rows))


def _lead(rows: pd.DataFrame) -> str:
    """The closed form is always there to be used; here it may not have been asked."""
    own = rows[rows["solver"] == EXACT]
    if own.empty:
        return "If you only need the path, use the closed form."
    right = int(own.groupby("question")["right"].min().sum())
    routes = ", or the search with a proof where there are via points"
    where = routes if legs_of(rows).gt(1).any() else ""
    return (
        f"If you only need the path, use the closed form{where}: right in time on "
        f"{count(right)} of {some(own['question'].nunique(), 'question')}. "
        "Of all others see what each must know."
    )


def _tables(
    attempts: Compared, rows: pd.DataFrame, labels: Mapping[str, str], *, few: bool, each: bool
) -> tuple[Table, ...]:
    """A line for each formulation and kind of guess; first those of the surest kind alone."""
    # an engine at other options is asked a sample only, and would count twice
    equal, best = rows[rows["solver"].map(_equal)], surest(rows)
    stop = stops(rows, attempts.strata) | stops(equal, attempts.strata)
    ended = ends(rows) | ends(equal)
    knows = rows.groupby("solver", observed=True)["knows"].first()
    experiments = list(dict.fromkeys(rows["experiment"]))
    by_kind: dict[tuple[str, str], dict[str, Any]] = {}
    for method in best.reset_index().to_dict("records"):
        kind = str(method["formulation"]), str(method["guesses"])
        line = by_kind.setdefault(kind, {"formulation": kind[0], "guesses": kind[1], "lows": []})
        line["method"] = kind[0] if kind[1] in _NO_GUESS else f"{kind[0]}, {kind[1]}"
        known = f"{line.get('knows', '')} {knows[method['solver']] or ''}"
        line["knows"] = " ".join(sorted({*known.split()}))
        line["lows"].append(method["low"])
        line["mine"] = bool(own_name(str(method["solver"])))
        named = "" if line["mine"] else f"{method['solver']}\n"
        line |= _cell(method, experiments.index(method["experiment"]), named)
    for kind, line in by_kind.items():
        end = ended[kind]
        ended_as = end["longer"], end["misses"], end["none"] + end["late"], end["not asked"]
        line["errs"] = " / ".join(f"{100 * part:.0f}" for part in ended_as)
        lows = line.pop("lows")
        line["false"] = f"{end['false_claims']:.0f} of {count(end['asked'])}"
        line |= end | {"stops": stop.get(kind, ""), "suites": len(lows), "sure": np.mean(lows)}
    frame = pd.DataFrame([*by_kind.values()]).sort_values(
        ["mine", "suites", "sure"], ascending=False, ignore_index=True
    )
    shown = (
        *columns(kind="text", method="method" if each else "formulation, guesses", knows="knows"),
        *(Column(f"suite_{n}", name, kind="pick spec") for n, name in enumerate(experiments)),
        *columns(kind="cell", errs="longer / misses / none / unasked, %"),
        *columns(kind="cell", false="false claims"),
        *(columns(kind="cell", stops="legs") if stop else ()),
    )
    suites = [f"suite_{n}_{k}" for n, _ in enumerate(experiments) for k in _NUMBERS]
    numbers = ("formulation", "guesses", *_ENDS, *suites)
    caption = sentences(
        f"The share right, with its 95 % interval by Wilson, then how the attempts end. Fewer than "
        f"{ENOUGH_TO_CHOOSE} questions choose no engine: every method has a line."
        if few
        else "The share right, with its 95 % interval by Wilson, then how the attempts end."
        if each
        else "The solver that is most surely right (share, 95 % interval by Wilson), then how the "
        "attempts of all engines end at equal options.",
        "None: no path in time. False claims: of attempts made.",
        "Legs: up to which an engine is right on most routes of each size, by spacing, long to "
        "short."
        if stop
        else "",
    )
    bad = {(row, "false"): mark for (row, _), mark in marks(frame, "false_claims").items()}
    table = Table("decision", caption, frame, shown, bad, numbers, stacked=True)
    kinds = frame["formulation"] + frame["guesses"]
    several = frame["suites"] >= min(2, len(experiments))
    first = kinds[frame["mine"] | (several & ~frame["formulation"].duplicated())]
    which = "Of each formulation, of the kinds of guesses that most suites ask, the surest."
    return best_first(table, kinds, {*first}, which)


def _equal(spec: str) -> bool:
    """Whether a solver has the options `equal`, or engine and options are its own affair."""
    return parse_spec(spec)[1].get("options", "equal") == "equal"


def _cell(best: Mapping[Hashable, Any], place: int, named: str) -> dict[str, Any]:
    """The texts and numbers of one method in one experiment."""
    name, text = f"suite_{place}", with_interval(share, best["share"], best["low"], best["high"])
    values = [best[key] for key in ("solver", "share", "low", "high", "wall_s")]
    return {name: f"{named}{text}"} | {
        f"{name}_{key}": value for key, value in zip(_NUMBERS, values, strict=True)
    }


TOPIC = Topic("where engines err", decision_section, General.DECIDED, place=Place.FRONT)
