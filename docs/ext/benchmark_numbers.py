"""Numbers of the committed benchmark.

They are counted at build time by the functions of the report.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pandas as pd
from markdown_text import prose, table

from dubins_study.report.data.results import Results, load
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.identity import percent, questions
from dubins_study.report.statistics.methods import best_methods, compared
from dubins_study.report.topics import findings
from dubins_study.report.topics.decision import decision_section
from dubins_study.report.topics.findings_evidence import Evidence
from dubins_study.report.topics.matrix import matrix, strata
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.words import FORMULATIONS

FOLDER = Path(__file__).parents[2] / "results" / "benchmark"
LEG = FOLDER / "leg"  # tables of formulations and engines are of its questions

_three = digits(3)


@cache
def _results() -> Results:
    return load([LEG])


@cache
def _methods() -> pd.DataFrame:
    """One row per method that was asked solvable questions."""
    methods = solver_summary(_results().attempts)
    return methods[methods["right_of"] > 0].reset_index(drop=True)


@cache
def _strata() -> pd.DataFrame:
    return strata(_results().rows)


def _of(key: str, value: str) -> pd.DataFrame:
    chosen = _methods()[_methods()[key] == value]
    if chosen.empty:
        raise LookupError(f"no rows; choose one of: {', '.join(sorted(set(_methods()[key])))}")
    return chosen


def formulation(name: str) -> str:
    """The engines of a formulation.

    Each has its most reliable guess and settings.
    """
    best = best_methods(_of("formulation", name), ["engine"])
    return _share_table(best.sort_values("right_low", ascending=False, kind="stable"))


def family(kind: str) -> str:
    """Engines of a family by formulation.

    Each has its share of right answers and its median time.
    """
    entries = [entry for folder in _results().folders for entry in folder.manifest.matrix]
    cells = matrix(_methods(), entries)
    chosen = cells[(cells["kind"] == kind) & cells["filled"]]
    if chosen.empty:
        raise LookupError(f"no rows; choose one of: {', '.join(sorted(set(cells['kind'])))}")
    formulations = [name for name in FORMULATIONS if name in set(chosen["formulation"])]
    text = {}
    for row in chosen.to_dict("records"):
        star = "*" if row["few"] else ""
        share = f"{percent(row['right_share'])} %{star}"
        milliseconds = _three(1e3 * row["wall_s"])
        text[row["engine"], row["formulation"]] = f"{share}, {milliseconds} ms"
    engines = list(dict.fromkeys(chosen["engine"]))
    rows = [[e, *(prose(text.get((e, name), "–")) for name in formulations)] for e in engines]
    return table(("engine", *formulations), rows)


def _share_table(methods: pd.DataFrame) -> str:
    rows = [
        (
            row["engine"],
            ", ".join(filter(None, (row["guess"].replace("none", ""), row["settings"]))) or "–",
            f"{percent(row['right_share'])} % of {questions(row['right_of'])}",
            f"{percent(row['right_low'])} to {percent(row['right_high'])}",
            _three(1e3 * row["wall_s"]),
            f"{row['wrong_basins']:.0f}",
            f"{row['false_claims']:.0f}",
        )
        for row in methods.to_dict("records")
    ]
    head = ("right", "95 %", "median ms", "wrong basins", "false claims")
    return table(("engine", "guess, settings", *head), rows)


def formulations() -> str:
    """The best-supported method of each formulation.

    The spread of its engines stands beside it.
    """
    rows = []
    measured = set(_methods()["formulation"])
    for name in filter(measured.__contains__, FORMULATIONS):
        engines = best_methods(_of("formulation", name), ["engine"])
        best = best_methods(engines, ["formulation"]).to_dict("records")[0]
        low, high = engines["right_share"].min(), engines["right_share"].max()
        rows.append(
            (
                name,
                best["short"],
                f"{percent(best['right_share'])} % of {questions(best['right_of'])}",
                f"{percent(best['right_low'])} to {percent(best['right_high'])}",
                _three(1e3 * best["wall_s"]),
                str(len(engines)),
                f"{percent(low)} to {percent(high)} %",
            )
        )
    head = (
        "formulation",
        "best supported",
        "right",
        "95 %",
        "median ms",
        "engines",
        "all engines",
    )
    return table(head, rows)


def by_stratum(name: str) -> str:
    """Right answers of a formulation, by stratum.

    They are those of its most reliable method, and show where the formulation fails.
    """
    methods = best_methods(_of("formulation", name), ["formulation"])
    best = methods.to_dict("records")[0]
    shares = _strata()[_strata()["solver"] == best["solver"]]
    rows = [
        (
            row["stratum"],
            f"{percent(row['share'])} % of {questions(row['trials'])}",
            f"{percent(row['low'])} to {percent(row['high'])}",
        )
        for row in shares.sort_values("share").to_dict("records")
    ]
    return table(("targets", f"right: {best['short']}", "95 %"), rows)


@cache
def _evidence() -> Evidence:
    attempts = compared(_results())
    if attempts is None:
        raise LookupError("the benchmark has no rows to compare")
    return Evidence(attempts)


def finding(name: str) -> str:
    """One sentence of the page's findings.

    It is named by the function that computes it.
    """
    result = getattr(findings, name)(_evidence())
    if result is None:
        raise LookupError("the rows do not carry this finding any more; drop it from the page")
    return prose(result.sentence)


@cache
def _whole() -> Results:
    return load([FOLDER])


def all_findings() -> str:
    """The page's first findings, as a list."""
    section = findings.findings_section(_whole())
    if section is None:
        raise LookupError("the rows of the benchmark carry no finding")
    sentences = section.blocks[0].frame["sentence"]
    return "\n".join(f"{n}. {prose(sentence)}" for n, sentence in enumerate(sentences, 1))


def decision() -> str:
    """Where engines err and where they stop.

    One line per formulation.
    """
    section = decision_section(_whole())
    if section is None or not section.blocks:
        raise LookupError("the rows of the benchmark carry no table of formulations")
    block = section.blocks[0]
    lines = [[prose(cell.replace("\n", ": ")) for cell in line] for line in block.texts()]
    head = [prose(column.title) for column in block.columns]
    return f"{prose(section.lead)}\n\n{table(head, lines)}\n\n{prose(block.caption)}"


SOURCES: dict[str, Callable[..., str]] = {
    "benchmark-formulation": formulation,
    "benchmark-formulations": formulations,
    "benchmark-family": family,
    "benchmark-strata": by_stratum,
    "finding": finding,
    "findings": all_findings,
    "decision": decision,
}
