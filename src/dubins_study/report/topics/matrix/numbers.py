"""The table formulation x engine: what each pair achieves at its best, or why it has no row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import pandas as pd

from dubins_study.report.data.attempts import TRIAL
from dubins_study.report.elements.shares import with_share
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import best_methods
from dubins_study.report.statistics.metrics import success
from dubins_study.study.rows.manifest import MatrixEntry
from dubins_study.study.words import FORMULATIONS

# The closed form is a formulation and needs no engine: it has no place in the table.
_FORMULA = FORMULATIONS[0]
_NOT_ASKED = "it can be asked, but no row of these folders does"
_NO_KIND = "other"


class Matrix(NamedTuple):
    """The table, long and as the lines of the page.

    Args:
        cells: one row per engine and formulation: kind, engine, formulation, the columns of the
            pair's best method (`filled`: whether there is one; `few`: whether it was asked less
            than half as many questions as others), reason (empty if filled), note (the reason's
            number, 0 if filled).
        engines: (kind, engine) in the order of lines.
        formulations: in the order of columns.
        reasons: by number, from 1.
    """

    cells: pd.DataFrame
    engines: list[tuple[str, str]]
    formulations: list[str]
    reasons: list[str]


def matrix(methods: pd.DataFrame, entries: Sequence[MatrixEntry]) -> Matrix:
    """Every formulation with every engine.

    Args:
        methods: one row per method: the columns of `with_share` for right, formulation, engine,
            guess, wall_s, and others.
        entries: the manifests'; without any, only the pairs that have rows.
    """
    asked = methods[(methods["formulation"] != _FORMULA) & (methods["right_of"] > 0)]
    best = best_methods(asked, ["engine", "formulation"]).assign(filled=True)
    known = [entry for entry in entries if entry.formulation != _FORMULA]
    with_rows = set(best["engine"])
    readable = {entry.engine for entry in known if entry.kind != "exact"} | with_rows
    known = [entry for entry in known if entry.engine in readable]
    engines = _engines(known, best)
    given = {*best["formulation"], *(entry.formulation for entry in known)}
    formulations = [name for name in FORMULATIONS if name in given]
    formulations += sorted(given - set(formulations))
    why = {(e.engine, e.formulation): e.reason or _NOT_ASKED for e in known}
    pairs = pd.DataFrame(
        [
            (kind, engine, formulation, why.get((engine, formulation), ""))
            for kind, engine in engines
            for formulation in formulations
        ],
        columns=["kind", "engine", "formulation", "reason"],
    )
    cells = pairs.merge(best, on=["engine", "formulation"], how="left")
    cells["filled"] = cells["filled"].eq(True)
    cells["few"] = cells["right_of"] < asked["right_of"].max() / 2
    cells["reason"] = cells["reason"].where(~cells["filled"], "")
    reasons = list(dict.fromkeys(reason for reason in cells["reason"] if reason))
    number = {reason: place for place, reason in enumerate(reasons, 1)}
    cells["note"] = cells["reason"].map(number).fillna(0).astype(int)
    return Matrix(cells, engines, formulations, reasons)


def _engines(entries: Sequence[MatrixEntry], best: pd.DataFrame) -> list[tuple[str, str]]:
    """(kind, engine) by kind in the order of entries; engines that no entry names last."""
    kind_of: dict[str, str] = {}
    for entry in entries:
        kind_of.setdefault(entry.engine, entry.kind or _NO_KIND)
    for engine in sorted(set(best["engine"]), key=str.casefold):
        kind_of.setdefault(engine, _NO_KIND if entries else "")
    kinds = list(dict.fromkeys(kind_of.values()))
    order = sorted(kind_of, key=lambda engine: kinds.index(kind_of[engine]))
    return [(kind_of[engine], engine) for engine in order]


def strata(rows: pd.DataFrame) -> pd.DataFrame:
    """The share of right answers of each solver in each stratum, where a path exists.

    Args:
        rows: attempts; their label names the stratum.

    Returns:
        One row per solver and stratum: solver, stratum, and those of `with_share` for right.
    """
    kept = rows[rows["answerable"]]
    kept = kept.assign(right=success(kept), stratum=kept["label"].fillna(""))
    shares = scenario_shares(kept, by=["solver", "stratum"], success="right", scenario=TRIAL)
    frame = shares.reset_index()
    return with_share(frame[["solver", "stratum"]], "right", frame["successes"], frame["trials"])
