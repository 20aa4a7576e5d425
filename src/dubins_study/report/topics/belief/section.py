"""The section on whom one can believe."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns, marks
from dubins_study.report.elements.content import Picture, Place, Section, Table
from dubins_study.report.elements.formats import count, digits, sentences, share, some
from dubins_study.report.elements.identity import (
    best_first,
    cell_text,
    interval_column,
    interval_keys,
    method_columns,
    with_interval,
    with_interval_texts,
)
from dubins_study.report.elements.panels import most_per_formulation
from dubins_study.report.elements.topic import BENCHMARK, Topic
from dubins_study.report.statistics.compared import Compared, compared
from dubins_study.report.topics.belief.figures import FEW, plot_beliefs
from dubins_study.report.topics.belief.numbers import (
    FALSE,
    PROOFS,
    TRUTHS,
    beliefs,
    claims,
    cures,
    false_proofs,
)
from dubins_study.report.topics.summary import best_solvers

_TOLERATED = PROOFS[1]
_MOST = 8  # bars in a panel, and columns of the table by stratum
_MOST_EXAMPLES = 40
_SHORT = dict(
    zip(
        PROOFS,
        (
            *("bound too high", "bound too high by its tolerance", "optimal, but longer"),
            *("infeasible, but has a path", "path, but misses"),
        ),
        strict=True,
    )
)


def belief_section(results: Results) -> Section | None:
    """What claims are worth, which proofs are false, and what cures them."""
    attempts = compared(results)
    if attempts is None:
        return None
    rows = claims(attempts)
    if rows.empty:
        return None
    names = attempts.methods
    table = names.join(beliefs(rows, ["solver"]), how="inner")
    table["attempts"] = rows[rows["truth"] == FALSE].groupby("solver").size()
    table["attempts"] = table["attempts"].fillna(0)
    false = false_proofs(rows)
    blocks: list[Picture | Table] = [
        _picture(table),
        *best_first(_belief_table(table), table.index, best_solvers(results)),
    ]
    if len(false):
        by_stratum = _stratum_table(rows, attempts)
        blocks.append(_kind_table(table))
        blocks += [by_stratum] if by_stratum is not None else []
        blocks.append(_proof_table(false, names))
        blocks.append(_cure_table(cures(rows, names), names))
    text = sentences(
        "A claim is true if it says "
        "no more than the check finds; a local solver's longer path is a true claim of a local "
        "optimum. It is less than known if a path arrives and the engine does not say so, or only "
        "calls the shortest path feasible. A bound may lie above the shortest length by what the "
        "engine's tolerance explains: such a claim is true to its tolerance. What the "
        "presolve answered is no engine's claim.",
        _liars(table),
    )
    lead = "See which engines say what is not so (crossed), and which say it of how many questions."
    return Section("belief", "Whom one can believe", text, tuple(blocks), lead)


def _liars(table: pd.DataFrame) -> str:
    liars = table[table["attempts"] > 0]
    if liars.empty:
        questions = int(table["questions"].max())
        return f"No method makes a false claim at any of up to {some(questions, 'question')}."
    # of a method that was asked few questions the share says little: the figure stars it
    asked = liars[liars["questions"] >= FEW * table["questions"].max()]
    if asked.empty:
        return f"{len(liars)} of {some(len(table), 'method')} make false claims."
    worst = asked.sort_values("false", ascending=False).to_dict("records")[0]
    text = with_interval(share, worst["false"], worst["false_low"], worst["false_high"])
    return (
        f"{len(liars)} of {some(len(table), 'method')} make false claims; most often, of "
        f"those asked at least half as many questions as others, {worst['name']}: at {text} of "
        f"its {some(int(worst['questions']), 'question')}."
    )


def _picture(table: pd.DataFrame) -> Picture:
    engines = table[table.index != EXACT].sort_values("false", ascending=False)
    shown = most_per_formulation(engines if len(engines) else table, _MOST)
    shown = table[table.index.isin(shown.index)]
    left_out = len(engines) - len(shown)
    rest = (
        f" {count(left_out)} methods with fewer false claims are left out." if left_out > 0 else ""
    )
    few = shown["questions"] < FEW * shown["questions"].max()
    star = " A star: asked less than half as many questions as others." if few.any() else ""
    caption = (
        "What the claims are worth, as shares of the questions, those without a path included; "
        f"at the right the number of attempts with a false claim.{star}{rest}"
    )
    alt = "Stacked bars of true, weak, silent and false claims, in panels by formulation"
    return Picture("belief-claims", caption, plot_beliefs(shown), alt)


def _belief_table(table: pd.DataFrame) -> Table:
    shown = (
        *method_columns(table),
        *columns(count, questions="questions"),
        *(interval_column(name, name) for name in TRUTHS),
    )
    caption = (
        "Shares of questions (one with a false claim in one of three repeats counts a third) with "
        "Wilson's 95 % intervals for as many trials as there are questions."
    )
    frame = with_interval_texts(table, **dict.fromkeys(TRUTHS, share))
    bad = {(row, "false_text"): "bad" for row, value in enumerate(table["false"]) if value}
    numbers = (*interval_keys(*TRUTHS), *PROOFS)
    return Table("belief", caption, frame, shown, bad, numbers, dense=True)


def _kind_table(table: pd.DataFrame) -> Table:
    """Of each method with false claims, or with bounds that its tolerance excuses, their kinds."""
    present = {name: title for name, title in _SHORT.items() if table[name].any()}
    frame = table[table[list(present)].any(axis="columns")].reset_index(names="solver")
    shown = (
        *method_columns(frame),
        *(Column(name, title, count) for name, title in present.items()),
    )
    caption = (
        "What is false in the false claims, in attempts: every repeat counts. A bound that is too "
        "high by no more than the engine's tolerance is listed too, and is no false claim."
    )
    bad = marks(frame, *(name for name in present if name != _TOLERATED))
    return Table("belief-kinds", caption, frame, shown, bad, numbers=("solver",))


def _stratum_table(rows: pd.DataFrame, attempts: Compared) -> Table | None:
    """The share of false claims in each stratum, for the methods that make any."""
    names = attempts.methods
    liars = rows.loc[rows["truth"] == FALSE, "solver"].value_counts().index[:_MOST]
    chosen = [solver for solver in names.index if solver in set(liars)]
    if rows["stratum"].nunique() < 2:
        return None
    table = beliefs(rows[rows["solver"].isin(chosen)], ["stratum", "solver"])
    ends = zip(table["false"], table["false_low"], table["false_high"], strict=True)
    texts = pd.Series([cell_text(with_interval(share, *each)) for each in ends], table.index)
    frame = texts.unstack("solver").reindex(attempts.strata).dropna(how="all")
    frame = frame.rename_axis(columns=None).reset_index(names="stratum")
    shown = (
        Column("stratum", "stratum", kind="text"),
        *(Column(solver, str(names["name"][solver]), kind="cell") for solver in chosen),
    )
    caption = (
        "Share of questions with a false claim, by stratum, with Wilson's 95 % intervals; the "
        f"{len(chosen)} methods with the most false claims."
    )
    return Table("belief-strata", caption, frame, shown, dense=True)


def _proof_table(false: pd.DataFrame, names: pd.DataFrame) -> Table:
    frame = names.reindex(false["solver"]).reset_index(drop=True)
    frame = frame.join(false.reset_index(drop=True)).head(_MOST_EXAMPLES)
    frame["kind_of_proof"] = frame["proof"].map(_SHORT)
    shown = (
        *columns(kind="text", name="method", kind_of_proof="what is false"),
        *columns(count, attempts="attempts", questions="questions"),
        *columns(
            digits(9), lower_bound="its bound", length="its length", reference_high="shortest"
        ),
        *columns(digits(2), most="bound too high by, at most", tolerance="tolerance"),
        *columns(kind="command", command="ask again"),
    )
    caption = (
        "False claims by name, each with its plainest example: the one with the roundest numbers, "
        "then the nearest target. Above the shortest length by its tolerance: relative to it by at "
        "most ten times the feasibility that the engine was asked for, which counts as true to its "
        "tolerance. Lengths in the scenario's unit; the shortest length is the upper end of its "
        "proven bounds. The command repeats the example."
    )
    return Table("belief-false", caption, frame, shown, dense=True)


def _cure_table(cure: pd.DataFrame, names: pd.DataFrame) -> Table:
    frame = names.reindex(cure["solver"]).reset_index(drop=True).join(cure)
    frame["cured_by"] = cure["cure"].map(names["name"]).fillna("none among the rows")
    shown = (
        *method_columns(frame),
        *columns(count, questions="questions with a false claim"),
        *columns(kind="text", cured_by="the same engine without false claims"),
        *columns(count, tried="asked of those questions", right="right"),
    )
    caption = (
        "What cures false claims, as far as the rows tell: methods with the same engine (and the "
        "same formulation, if there is one) that make no false claim at any question."
    )
    return Table("belief-cures", caption, frame, shown)


TOPIC = Topic("whom one can believe", belief_section, BENCHMARK, place=Place.FRONT)
