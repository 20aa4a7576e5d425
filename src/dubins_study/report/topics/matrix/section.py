"""The section on formulation x engine: right answers and times of every pair, by stratum too."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.data.verdicts import evaluations
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import Picture, Place, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, sentences, some
from dubins_study.report.elements.identity import METHOD, best_first
from dubins_study.report.elements.plots import HIGHEST
from dubins_study.report.elements.shares import INTERVAL_TEXT, percent, questions
from dubins_study.report.elements.style import WIDE
from dubins_study.report.elements.topic import BENCHMARK, Topic
from dubins_study.report.topics.matrix.figures import plot_matrix
from dubins_study.report.topics.matrix.numbers import Matrix, matrix, strata
from dubins_study.report.topics.matrix.strata import strata_blocks
from dubins_study.report.topics.summary import best_solvers, solver_summary


def matrix_section(results: Results) -> Section | None:
    """Formulation x engine as a picture and two tables; the shares by stratum."""
    attempts = results.attempts
    methods = solver_summary(attempts).merge(evaluations(attempts), on="solver", how="left")
    methods = methods[methods["right_of"] > 0].reset_index(drop=True)
    entries = [entry for run in results.folders for entry in run.manifest.matrix]
    table = matrix(methods, entries)
    if not table.cells["filled"].any():
        return None
    blocks: list[Picture | Table] = [_picture(table), _table(table)]
    if table.reasons:
        blocks.append(_reasons(table))
    best = best_solvers(results)
    blocks += best_first(_methods(methods), methods["solver"], best)
    blocks += strata_blocks(results, methods, strata(results.rows), best)
    lead = (
        "Read along a line for what the formulation buys, down a column for what the engine buys."
    )
    return Section("matrix", "Formulation by engine", _text(table), tuple(blocks), lead)


def _text(table: Matrix) -> str:
    filled = table.cells[table.cells["filled"]]
    spanned = filled[~filled["few"]]
    spans = [_span(spanned, key) for key in ("formulation", "engine")]
    return sentences(
        "A result belongs to a formulation, an engine and an initial guess.",
        f"Of {some(len(table.cells), 'pair')} ({count(len(table.engines))} engines, "
        f"{count(len(table.formulations))} formulations) {count(len(filled))} have rows; the "
        "others have a reason."
        if table.reasons
        else f"{some(len(filled), 'pair')} of {some(len(table.engines), 'engine')} and "
        f"{some(len(table.formulations), 'formulation')} have rows.",
        *filter(None, spans),
    )


def _span(filled: pd.DataFrame, key: str) -> str:
    """The formulation, or the engine, whose best guesses differ most across the other."""
    other = "engine" if key == "formulation" else "formulation"
    groups = filled.groupby(key, sort=False)["right_share"]
    spans = (groups.max() - groups.min())[groups.size() > 1]
    if spans.empty or not spans.max() > 0:
        return ""
    name = spans.idxmax()
    pairs = filled[filled[key] == name].sort_values("right_share", kind="stable")
    low, high = pairs.iloc[0], pairs.iloc[-1]
    return (
        f"Over {other}s, {name} differs most: from {percent(low['right_share'])} % right "
        f"({low[other]}) to {percent(high['right_share'])} % ({high[other]})."
    )


def _picture(table: Matrix) -> Picture:
    star = " A star: asked less than half as many questions." if table.cells["few"].any() else ""
    return picture(
        "matrix",
        plot_matrix,
        table,
        caption="Share of questions with a path that are answered right, in percent, with the best "
        "of the pair's initial guesses and settings; darker for more. In brackets: the number of "
        f"the reason below why a pair has no row.{star}",
        alt="Map of right answers, engines by formulations",
        height=min(HIGHEST, 0.75 + 0.19 * max(len(table.engines), 5)),
        width=WIDE,
    )


def _cell(row: Mapping[Hashable, Any]) -> str:
    if not row["filled"]:
        return f"[{row['note']}]" if row["note"] else ""
    low, high = percent(row["right_low"]), percent(row["right_high"])
    milliseconds = digits(3)(1e3 * row["wall_s"])
    few = f"\nof {questions(row['right_of'])}" if row["few"] else ""
    return f"{percent(row['right_share'])} %\n{low}–{high}\n{milliseconds} ms{few}"


def _table(table: Matrix) -> Table:
    cells = table.cells.assign(text=[_cell(row) for row in table.cells.to_dict("records")])
    wide = cells.pivot(index="engine", columns="formulation", values="text")
    wide = wide.reindex([engine for _, engine in table.engines]).reset_index()
    wide["kind"] = [kind for kind, _ in table.engines]
    wide["named"] = [f"{engine} ({kind})" if kind else engine for kind, engine in table.engines]
    shown = (
        *columns(kind="text", named="engine"),
        *(Column(name, name, kind="cell") for name in table.formulations),
    )
    empty = {
        (line, name): "note"
        for line, (_, engine) in enumerate(table.engines)
        for name in cells.loc[(cells["engine"] == engine) & ~cells["filled"], "formulation"]
    }
    caption = (
        "Every formulation with every engine: questions with a path that are answered right, the "
        "95 % interval (Wilson, a trial a question), and the median time of an attempt, failures "
        "included; with the guess and settings that are most surely right, which the table of all "
        "methods names. Chosen after the fact, the best of several guesses flatters a little. The "
        "number of questions stands where it is less than half that of others. A number in "
        "brackets is the reason why a pair has no row."
    )
    return Table("matrix", caption, wide, shown, empty, ("engine", "kind"), dense=True)


def _reasons(table: Matrix) -> Table:
    pairs = table.cells["note"].value_counts()
    frame = pd.DataFrame(
        {
            "note": [f"[{number}]" for number in range(1, len(table.reasons) + 1)],
            "reason": table.reasons,
            "pairs": [int(pairs[number]) for number in range(1, len(table.reasons) + 1)],
        }
    )
    shown = (
        *columns(kind="text", note="number"),
        *columns(kind="prose", reason="why the pair has no row"),
        *columns(count, pairs="pairs"),
    )
    return Table("matrix-reasons", "Reasons for pairs without rows.", frame, shown)


def _methods(methods: pd.DataFrame) -> Table:
    shown = (
        *METHOD[:-1],
        SOLVER,
        *columns(kind="cell", right_text="right of n, 95 %"),
        *columns(count, wrong_basins="wrong basins", false_claims="false claims"),
        *columns(seconds, wall_s="median time"),
        *columns(digits(3), evaluations="evaluations, median"),
    )
    caption = (
        f"Questions that have a path. {INTERVAL_TEXT} Wrong basins and false claims "
        "count attempts. A dash: the engine does not count its evaluations."
    )
    numbers = ("attempts", "right_of", "right_share", "right_low", "right_high", "settings")
    return Table("methods", caption, methods, shown, marks(methods, "false_claims"), numbers)


TOPIC = Topic("formulation by engine", matrix_section, BENCHMARK, counted=True, place=Place.FRONT)
