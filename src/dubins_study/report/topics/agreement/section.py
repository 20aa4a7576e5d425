"""The section on agreement between solvers."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Section, Table, picture
from dubins_study.report.elements.formats import count, digits, sentences, share
from dubins_study.report.elements.names import labels_of
from dubins_study.report.elements.plots import HIGHEST
from dubins_study.report.elements.style import WIDE
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import MOST_METHODS, best_of_formulations
from dubins_study.report.topics.agreement.figures import plot_agreement
from dubins_study.report.topics.agreement.numbers import agreement
from dubins_study.report.topics.summary import solver_summary

_COLUMNS = (
    *columns(kind="solver", first="solver", second="and"),
    *columns(count, questions="questions", both="both arrive"),
    *columns(digits(3), median="median", largest="largest"),
    *columns(share, within="agree to 1e-6"),
    *columns(digits(3), apart_median="paths, median", apart_largest="paths, largest"),
)


def agreement_section(results: Results) -> Section | None:
    """Matrix and table of all pairs of solvers; of many, of the best of each formulation."""
    if results.rows["solver"].nunique() > MOST_METHODS:
        return formulations_section(results)
    return _section(results, results.rows, "agreement", "Agreement", "")


def formulations_section(results: Results) -> Section | None:
    """Matrix and table of the best engine, guess and settings of each formulation."""
    methods = solver_summary(results.attempts)
    best = methods[methods["solver"].isin(best_of_formulations(methods))]
    rows = results.rows[results.rows["solver"].isin(best["solver"])]
    which = (
        "Of each formulation the engine, guess and settings that are most surely right, the "
        "fastest of several."
    )
    key, title = "agreement-formulations", "Agreement between formulations"
    return _section(results, rows, key, title, which, best["solver"].tolist())


def _section(
    results: Results,
    rows: pd.DataFrame,
    key: str,
    title: str,
    which: str,
    order: list[str] | None = None,
) -> Section | None:
    if rows["solver"].nunique() < 2:
        return None
    pairs = agreement(rows, results.path, order)
    pairs = pairs[pairs["questions"] > 0].reset_index(drop=True)
    if not (pairs["both"] > 0).any():
        return None
    matrix = picture(
        key,
        plot_agreement,
        *(pairs, labels_of(results)),
        caption="Below the diagonal: the largest |La − Lb| / max(reference, R) of each pair, "
        "darker for more. Above it: the share of common answers that agree to 1e-6. Empty: no "
        "common answer.",
        alt="Matrix of agreement between solvers",
        height=min(HIGHEST, 0.6 + 0.36 * (1 + pairs["first"].nunique())),
        width=WIDE,
    )
    caption = (
        "Differences in length, and the largest distance between the two paths at equal arc "
        "length, both over max(reference, R). Equal lengths with distant paths are ties, or flat "
        "optima."
    )
    text = sentences(
        "Only cold starts, the first repeat of each, and questions where both arrive; the table "
        "says how many.",
        which,
    )
    lead = "See how far the lengths, and the paths, of two solvers are apart where both arrive."
    return Section(key, title, text, (matrix, Table(key, caption, pairs, _COLUMNS)), lead)


TOPIC = Topic("agreement", agreement_section, General.COMPARED)
