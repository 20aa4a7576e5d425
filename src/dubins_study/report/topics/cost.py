"""The section on what evaluations and seconds go to."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, own
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import (
    BENCHMARK,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, seconds, sentences
from dubins_study.report.elements.identity import (
    best_first,
    interval_column,
    method_table,
)
from dubins_study.report.elements.plots import Mark, stacked_shares
from dubins_study.report.elements.style import BLUE, GREEN, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.costs import AMOUNTS, KINDS, Split, split
from dubins_study.report.statistics.intervals import medians
from dubins_study.report.statistics.methods import Compared, compared
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.report.topics.summary import best_solvers

# The figure: from dark to light with hatches, so that neighbours differ in grey print.
MARKS = (
    Mark("winning run", colour=BLUE),
    Mark("restarts", colour="#b9def3", hatch="///"),
    Mark("losing words", colour=ORANGE, hatch="\\\\\\"),
    Mark("words without a path", colour=VERMILION, hatch="xx"),
    Mark("building", colour=GREEN, hatch="||"),
    Mark("rest", colour=RULE),
)
# Eight bars in a panel can be read; the tables hold every method.
_MOST = 8
# Other runs with less than this share of the cost are nothing to show.
_OTHER_RUNS = ("restarts", "losing words", "words without a path")
_HARDLY = 0.005
_RATIO = digits(3)
_SHOWN = {"evaluations": _RATIO, "seconds": _RATIO}
FACTORS = (
    *columns(count, questions="questions"),
    *columns(_RATIO, evaluations_total="evaluations", evaluations_floor="winning run"),
    interval_column("evaluations", "total / winning"),
    *columns(seconds, seconds_total="time", seconds_floor="winning run"),
    interval_column("seconds", "total / winning"),
)


def ratios(split: Split, amount: str) -> pd.DataFrame:
    """Total / winning run, the median over repeats; questions by solvers, NaN where not right."""
    parts = split.amount(amount)
    return split.medians(parts["total"] / parts["winning run"])


def factors(compared: Compared, split: Split) -> pd.DataFrame:
    """Median over questions of total / winning run, with intervals over scenarios.

    A row per method, with its columns; questions (those with a right answer whose winning run is
    known); and for evaluations and seconds the median (as `evaluations`), its interval (`_low`,
    `_high`), and the means over answers of the total (`_total`) and of the winning run (`_floor`).
    """
    solver = split.answers["solver"]
    questions = split.answers.groupby("solver")["question"].nunique().rename("questions")
    frame = compared.methods.join(questions, how="inner")
    for amount in AMOUNTS:
        intervals = compared.bootstrap(ratios(split, amount), medians, amount)
        means = split.amount(amount)[["total", "winning run"]].groupby(solver).mean()
        means.columns = pd.Index([f"{amount}_total", f"{amount}_floor"])
        frame = frame.join(intervals).join(means)
    return frame


def shares(compared: Compared, split: Split, amount: str) -> pd.DataFrame:
    """What the total goes to: the mean amount of each kind over the mean total.

    A row per method that counts the amount, with its columns, each of `KINDS` as a share, and total
    (mean over answers).
    """
    means = split.amount(amount).groupby(split.answers["solver"]).mean().dropna()
    parts = means[list(KINDS)].div(means["total"], axis=0)
    return compared.methods.join(parts.assign(total=means["total"]), how="inner")


def presolve_pairs(methods: pd.DataFrame) -> list[tuple[str, str]]:
    """(without, with): solvers that differ in the setting `presolve` alone."""
    alike: dict[tuple[str, frozenset[tuple[str, str]]], dict[str, str]] = {}
    for spec in methods.index:
        name, settings = parse_spec(spec)
        value = settings.pop("presolve", "").lower()
        alike.setdefault((name, frozenset(settings.items())), {})[value] = spec
    # a spec that does not name the setting has the other value
    return [
        (specs.get("false", specs.get("", "")), specs.get("true", specs.get("", "")))
        for specs in alike.values()
        if len(specs) > 1
    ]


def cost_section(results: Results) -> Section | None:
    """What evaluations and seconds go to, against one run of the engine."""
    attempts = compared(results)
    if attempts is None:
        return None
    answers = split(attempts)
    if answers.answers.empty:
        return None
    table = factors(attempts, answers)
    parts = {amount: shares(attempts, answers, amount) for amount in AMOUNTS}
    blocks: list[Picture | Table] = [
        _picture(attempts, part, amount) for amount, part in parts.items() if len(part)
    ]
    blocks += best_first(_factor_table(table), table.index, best_solvers(results))
    text = sentences(
        "Besides the run that gives the answer, the cost goes to restarts, to words that lose, to "
        "words that have no path, and to building. Only right answers at questions with a path "
        "count. The floor is the winning run: the same engine called once, from the same guess.",
        _most_and_least(table),
    )
    lead = "See how little of the cost is the run that gives the answer (plain blue)."
    return Section("cost", "Cost where it arises", text, tuple(blocks), lead)


def _most_and_least(table: pd.DataFrame) -> str:
    ratios = table.loc[table["questions"] >= ENOUGH_TO_CHOOSE, "evaluations"].dropna()
    if len(ratios) < 2:
        return ""
    order = table.loc[ratios.sort_values().index].to_dict("records")
    best, worst = order[0], order[-1]
    return (
        f"In the median over {count(worst['questions'])} questions {worst['name']} takes "
        f"{_RATIO(worst['evaluations'])} times the evaluations of its winning run, over "
        f"{count(best['questions'])} {best['name']} {_RATIO(best['evaluations'])} times."
    )


def _picture(attempts: Compared, table: pd.DataFrame, amount: str) -> Picture:
    """The `shares` of the kinds as bars, the mean total beside each."""
    shown = _bars(table, attempts)
    show, label = {
        "evaluations": (_RATIO, "share of evaluations, right answers"),
        "seconds": (seconds, "share of the time, right answers"),
    }[amount]
    caption = (
        f"What the {amount} of an answer go to; at the right their mean number. Winning run: the "
        "run that gives the answer. Restarts: other runs on the same word. Losing words have a "
        "longer path, or are the joint model's other order. Methods of a single run are left out"
        f"{f', and {count(len(table) - len(shown))} methods in all' * (len(table) > len(shown))}."
    )
    alt = f"Stacked bars of the shares of {amount}, one per method, in panels by formulation"
    noted = shown.assign(note=shown["total"].map(show))
    return panels_picture(f"cost-{amount}", caption, stacked_shares, alt, noted, MARKS, label)


def _bars(table: pd.DataFrame, attempts: Compared) -> pd.DataFrame:
    """The methods with more than one run: those with and without the presolve, then the cheapest.

    If all have a single run, the cheapest; of each formulation as many as a panel may have.
    """
    paired = {solver for pair in presolve_pairs(attempts.engines) for solver in pair}
    order = table.assign(single=~table.index.isin(list(paired))).sort_values(["single", "total"])
    several = order[order[list(_OTHER_RUNS)].sum(axis=1) > _HARDLY]
    chosen = (several if len(several) else order).groupby("formulation", sort=False).head(_MOST)
    return table[table.index.isin([*own(table.index), *chosen.index])]


def _factor_table(table: pd.DataFrame) -> Table:
    caption = (
        "Total cost against the winning run: means over right answers, then the median over "
        "questions of total / winning run, with its 95 % interval (bootstrap over scenarios). "
        "A dash: the engine does not count evaluations."
    )
    return method_table("cost", caption, table, FACTORS, **_SHOWN)


TOPIC = Topic("cost where it arises", cost_section, BENCHMARK)
