"""The section on what evaluations and seconds go to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, digits, seconds, sentences
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
from dubins_study.report.topics.cost.efforts import Split, split
from dubins_study.report.topics.cost.figures import plot_cost_shares
from dubins_study.report.topics.cost.numbers import (
    example,
    factors,
    presolve_pairs,
    presolve_savings,
    shares,
    strata,
)
from dubins_study.report.topics.summary.section import best_solvers

# Eight bars in a panel can be read; the tables hold every method.
_MOST = 8
# Other runs with less than this share of the cost are nothing to show.
_OTHER_RUNS = ("restarts", "losing words", "words without a path")
_HARDLY = 0.005
_RATIO = digits(3)
_SHOWN = {"evaluations": _RATIO, "seconds": _RATIO}


def cost_section(results: Results) -> Section | None:
    """What evaluations and seconds go to, against one run of the engine."""
    attempts = compared(results)
    if attempts is None:
        return None
    answers = split(attempts)
    if answers.answers.empty:
        return None
    table = factors(attempts, answers)
    savings = presolve_savings(attempts, answers)
    blocks: list[Picture | Table] = [
        _picture(attempts, answers, amount)
        for amount in ("evaluations", "seconds")
        if len(shares(attempts, answers, amount))
    ]
    blocks += best_first(_factor_table(table), table.index, best_solvers(results))
    if len(savings):
        blocks.append(_presolve_table(savings))
    by_strata = strata(attempts, answers, "evaluations")
    by_stratum = _stratum_table(attempts, answers, by_strata)
    if by_stratum is not None:
        blocks.append(by_stratum)
    text = sentences(
        "Besides the run that gives the answer, the cost goes to restarts, to words that lose, to "
        "words that have no path, and to building. Only right answers at questions with a path "
        "count. The floor is the winning run: the same engine called once, from the same guess.",
        _most_and_least(table),
        _saved(savings),
        _typical(attempts, by_strata),
        _example(example(attempts, answers)),
    )
    lead = "See how little of the cost is the run that gives the answer (plain blue)."
    return Section("cost", "Cost where it arises", text, tuple(blocks), lead)


def _most_and_least(table: pd.DataFrame) -> str:
    ratios = table["evaluations"].dropna()
    if len(ratios) < 2:
        return ""
    order = table.loc[ratios.sort_values().index].to_dict("records")
    best, worst = order[0], order[-1]
    return (
        f"In the median over questions {worst['name']} takes {_of(worst, 'evaluations')} times the "
        f"evaluations of its winning run, {best['name']} {_of(best, 'evaluations')} times."
    )


def _of(row: Mapping[Any, Any], key: str) -> str:
    return with_interval(_RATIO, row[key], row[f"{key}_low"], row[f"{key}_high"])


def _saved(savings: pd.DataFrame) -> str:
    order = savings.dropna(subset="evaluations").sort_values("evaluations").to_dict("records")
    if not order:
        return ""
    ends = [order[-1]] if len(order) == 1 else [order[-1], order[0]]
    parts = [f"of {row['name']} by {_of(row, 'evaluations')}" for row in ends]
    between = " (the most) and " if len(parts) > 1 else ""
    last = " (the least)" if len(parts) > 1 else ""
    return f"The presolve divides the evaluations, in the median, {between.join(parts)}{last}."


def _typical(attempts: Compared, by_strata: pd.DataFrame) -> str:
    """The median over the strata of the methods that are posed with and without the presolve."""
    medians = _over_strata(by_strata)
    pairs = [pair for pair in presolve_pairs(attempts.engines) if set(pair) <= set(medians.index)]
    parts = [
        f"{attempts.methods['engine'][on]} {_RATIO(medians[on])} ({_RATIO(medians[off])} without)"
        for off, on in pairs
    ]
    if not parts or by_strata["stratum"].nunique() < 2:
        return ""
    return (
        "Evaluations with the presolve as a multiple of those of the winning run, median over the "
        f"strata: {'; '.join(parts)}."
    )


def _example(table: pd.DataFrame) -> str:
    parts = [f"{row['name']} {_RATIO(row['ratio'])}" for row in table.to_dict("records")]
    if not parts:
        return ""
    return (
        "For the target (10, 5) from (0, 0, 120°) at R = 4, the evaluations as a multiple of those "
        f"of the winning run: {'; '.join(parts)}."
    )


def _picture(attempts: Compared, answers: Split, amount: str) -> Picture:
    table = shares(attempts, answers, amount)
    shown = _bars(table, attempts)
    left_out = len(table) - len(shown)
    rest = f" The table below has {count(left_out)} methods more." if left_out else ""
    if amount == "evaluations":
        what = "function evaluations; at the right their mean number in an answer"
    else:
        what = "seconds, building included; at the right their mean in an answer"
    caption = (
        f"What an answer's cost goes to, in {what}. Winning run: the run that gives the answer. "
        "Restarts: other runs on the same word. Losing words have a path, but a longer one, or "
        "are the joint model's other order. Whether a word has a path is computed from the "
        f"scenario. Methods of a single run are left out.{rest}"
    )
    alt = f"Stacked bars of the shares of {amount}, one per method, in panels by formulation"
    return Picture(f"cost-{amount}", caption, plot_cost_shares(shown, amount), alt)


def _bars(table: pd.DataFrame, attempts: Compared) -> pd.DataFrame:
    """The methods with more than one run: those with and without the presolve, then the cheapest.

    If all have a single run, the cheapest.
    """
    paired = {solver for pair in presolve_pairs(attempts.engines) for solver in pair}
    order = table.assign(single=~table.index.isin(list(paired))).sort_values(["single", "total"])
    several = order[order[list(_OTHER_RUNS)].sum(axis=1) > _HARDLY]
    chosen = most_per_formulation(several if len(several) else order, _MOST)
    return table[table.index.isin(chosen.index)]


def _factor_table(table: pd.DataFrame) -> Table:
    mean = digits(3)
    shown = (
        *method_columns(table),
        *columns(count, questions="questions"),
        *columns(mean, evaluations_total="evaluations", evaluations_floor="winning run"),
        interval_column("evaluations", "total / winning"),
        *columns(seconds, seconds_total="time", seconds_floor="winning run"),
        interval_column("seconds", "total / winning"),
    )
    caption = (
        "Total cost against the winning run: means over right answers, then the median over "
        "questions of total / winning run, with its 95 % interval (bootstrap over scenarios). "
        "A dash: the engine does not count evaluations."
    )
    frame = with_interval_texts(table, **_SHOWN)
    return Table("cost", caption, frame, shown, numbers=interval_keys(*_SHOWN), dense=True)


def _presolve_table(savings: pd.DataFrame) -> Table:
    shown = (
        *method_columns(savings),
        *columns(count, questions="questions"),
        *columns(_RATIO, evaluations_off="evaluations / winning, without", evaluations_on="with"),
        interval_column("evaluations", "saved factor"),
        *columns(_RATIO, seconds_off="time / winning, without", seconds_on="with"),
        interval_column("seconds", "saved factor"),
    )
    caption = (
        "With and without the presolve, which drops the words that elementary geometry excludes, "
        "on the questions that both answer: median of total / winning run, and median over "
        "questions of the total without / with it, with its 95 % interval."
    )
    frame = with_interval_texts(savings, **_SHOWN)
    return Table("cost-presolve", caption, frame, shown, numbers=interval_keys(*_SHOWN), dense=True)


def _present(attempts: Compared, table: pd.DataFrame) -> list[str]:
    return [stratum for stratum in attempts.strata if stratum in set(table["stratum"])]


def _stratum_table(attempts: Compared, answers: Split, table: pd.DataFrame) -> Table | None:
    """Strata in lines, the methods of the first formulation of the figure in columns."""
    kinds = shares(attempts, answers, "evaluations")
    bars = _bars(kinds, attempts)
    chosen = list(bars[bars["formulation"] == bars["formulation"].head(1).squeeze()].index)
    kept = table[table["solver"].isin(chosen)]
    if kept.empty or kept["stratum"].nunique() < 2:
        return None
    ends = zip(kept["estimate"], kept["low"], kept["high"], strict=True)
    kept = kept.assign(text=[cell_text(with_interval(digits(2), *each)) for each in ends])
    texts = kept.pivot(index="stratum", columns="solver", values="text")
    texts = texts.reindex(index=_present(attempts, kept), columns=chosen)
    medians = _over_strata(table).reindex(chosen)
    texts.loc["median over the strata"] = [digits(2)(value) for value in medians]
    frame = texts.reset_index()
    names = attempts.methods["short"]
    shown = (
        Column("stratum", "stratum", kind="text"),
        *(Column(solver, str(names[solver]), kind="cell") for solver in chosen),
    )
    caption = (
        "Evaluations / those of the winning run, by stratum: median over questions with its 95 % "
        f"interval; {attempts.methods.loc[chosen[0], 'formulation']}."
    )
    return Table("cost-strata", caption, frame, shown, dense=True)


def _over_strata(table: pd.DataFrame) -> pd.Series[float]:
    """The median over strata of each solver's median over questions."""
    return table.groupby("solver")["estimate"].median()


TOPIC = Topic("cost where it arises", cost_section, BENCHMARK)
