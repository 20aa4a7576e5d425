"""Total cost against that of the winning run, by method, by stratum, and with the presolve."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.compared import Compared
from dubins_study.report.statistics.intervals import bootstrap, medians
from dubins_study.report.statistics.methods import without_setting
from dubins_study.report.topics.cost.efforts import KINDS, Split
from dubins_study.study.scenario import Scenario

AMOUNTS = ("evaluations", "seconds")
_STRATUM_COLUMNS = ["solver", "stratum", "questions", "estimate", "low", "high"]


def ratios(split: Split, amount: str) -> pd.DataFrame:
    """Total / winning run, the median over repeats; questions by solvers, NaN where not right."""
    parts = split.amount(amount)
    return split.medians(parts["total"] / parts["winning run"])


def factors(compared: Compared, split: Split) -> pd.DataFrame:
    """Median over questions of total / winning run, with intervals over scenarios.

    Returns:
        Indexed by solver in the order of tables: the method's columns; questions (those with a
        right answer whose winning run is known); and for evaluations and seconds the median (as
        `evaluations`), its interval (`_low`, `_high`), and the means over answers of the total
        (`_total`) and of the winning run (`_floor`).
    """
    solver = split.answers["solver"]
    questions = split.answers.groupby("solver")["question"].nunique().rename("questions")
    frame = compared.methods.join(questions, how="inner")
    for amount in AMOUNTS:
        found = bootstrap(compared.by_scenario(ratios(split, amount)), medians)
        means = split.amount(amount)[["total", "winning run"]].groupby(solver).mean()
        means.columns = pd.Index([f"{amount}_total", f"{amount}_floor"])
        frame = frame.join(_named(found, amount)).join(means)
    return frame


def _named(intervals: pd.DataFrame, amount: str) -> pd.DataFrame:
    names = {"estimate": amount, "low": f"{amount}_low", "high": f"{amount}_high"}
    return intervals.rename(columns=names)


def shares(compared: Compared, split: Split, amount: str) -> pd.DataFrame:
    """What the total goes to: the mean amount of each kind over the mean total.

    Returns:
        Indexed by solver in the order of tables: the method's columns, each of `KINDS` as a share,
        and total (mean over answers). Methods that do not count the amount are left out.
    """
    means = split.amount(amount).groupby(split.answers["solver"]).mean().dropna()
    parts = means[list(KINDS)].div(means["total"], axis=0)
    return compared.methods.join(parts.assign(total=means["total"]), how="inner")


def strata(compared: Compared, split: Split, amount: str) -> pd.DataFrame:
    """Median of total / winning run in each stratum, with its interval.

    Returns:
        One row per solver and stratum: solver, stratum, questions, estimate, low, high.
    """
    table = ratios(split, amount)
    stratum_of = compared.rows.drop_duplicates("question").set_index("question")["stratum"]
    parts = []
    for stratum, group in table.groupby(stratum_of.reindex(table.index), sort=False):
        found = bootstrap(compared.by_scenario(group), medians).rename_axis("solver")
        counted = group.notna().sum().rename_axis("solver")
        parts.append(found.assign(stratum=str(stratum), questions=counted).reset_index())
    if not parts:
        return pd.DataFrame(columns=_STRATUM_COLUMNS)
    every = pd.concat(parts, ignore_index=True)
    return every.loc[every["questions"] > 0, _STRATUM_COLUMNS]


def presolve_pairs(methods: pd.DataFrame) -> list[tuple[str, str]]:
    """(without, with): solvers that differ in the setting `presolve` alone."""
    plain = {spec: without_setting(spec, "presolve") for spec in methods.index}
    pairs = []
    for spec, (rest, value) in plain.items():
        for other, (other_rest, other_value) in plain.items():
            if value is not None and other_rest == rest and other_value != value:
                on = value.lower() == "true"
                pairs.append((other, spec) if on else (spec, other))
    return list(dict.fromkeys(pairs))


def presolve_savings(compared: Compared, split: Split) -> pd.DataFrame:
    """What the presolve divides the cost by: median over questions, with interval.

    Returns:
        One row per pair of solvers: the columns of the method without it; questions that both
        answer; for evaluations and seconds the ratio total without / total with (as
        `evaluations`) with `_low` and `_high`, and total / winning run of both (`_off`, `_on`).
    """
    known = set(split.answers["solver"])
    pairs = [pair for pair in presolve_pairs(compared.engines) if known.issuperset(pair)]
    off, on = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    frame = compared.methods.reindex(off).assign(settings="").reset_index(drop=True)
    for amount in AMOUNTS:
        totals, floors = split.medians(split.amount(amount)["total"]), ratios(split, amount)
        saved = totals[off].to_numpy() / totals[on].to_numpy()
        savings = pd.DataFrame(saved, totals.index)
        frame["questions"] = savings.notna().sum()
        found = bootstrap(compared.by_scenario(savings), medians)
        frame = frame.join(_named(found, amount))
        both = savings.notna().to_numpy()
        for suffix, solvers in (("_off", off), ("_on", on)):
            table = pd.DataFrame(np.where(both, floors[solvers].to_numpy(), np.nan))
            frame[f"{amount}{suffix}"] = table.median()
    return frame


_EXAMPLE = Scenario(0, 0, "120deg", 10, 5, 4)
_NUMBERS = ["x", "y", "heading", "target_x", "target_y", "radius"]


def example(compared: Compared, split: Split) -> pd.DataFrame:
    """Total / winning run in evaluations for the target (10, 5) from (0, 0, 120deg) at R = 4.

    Returns:
        The method's columns and `ratio`, one row per solver; empty if no row asks the question.
    """
    rows = compared.rows.loc[split.answers.index]
    numbers = rows[_NUMBERS].to_numpy(dtype=np.float64)
    wanted = [getattr(_EXAMPLE, name) for name in _NUMBERS]
    here = np.isclose(numbers, wanted, rtol=0, atol=1e-9).all(axis=1) & (rows["branch"] == "best")
    each = split.evaluations["total"] / split.evaluations["winning run"]
    ratio = each[here].groupby(rows.loc[here, "solver"]).median().rename("ratio").dropna()
    return compared.engines.join(ratio, how="inner")
