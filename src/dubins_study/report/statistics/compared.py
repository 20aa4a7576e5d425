"""The attempts by which solvers are compared, and the methods that made them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT, SUCCESSES, TRIAL
from dubins_study.report.data.results import Results
from dubins_study.report.statistics.methods import methods_of
from dubins_study.report.statistics.metrics import presolved
from dubins_study.study.rows.schema import ROW

_NEVER_SOLVED = ("unavailable", "unsupported")


Rows = TypeVar("Rows")
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Compared:
    """Cold attempts of engines that could be called, and the time limit of an attempt.

    `rows` has most columns of the schema, and question and scenario (whole numbers), right (the
    check accepts the answer, and an engine gave it) and stratum (the scenario's label). `methods`
    is the frame of `methods_of`; `strata` are in the order of the experiment's file.
    """

    rows: pd.DataFrame
    methods: pd.DataFrame
    limit_s: float
    strata: tuple[str, ...]

    @cached_property
    def answerable(self) -> pd.DataFrame:
        """The attempts at questions that have a path."""
        return self.rows[self.rows["answerable"]]

    @cached_property
    def engines(self) -> pd.DataFrame:
        """The methods without the closed form."""
        return self.methods[self.methods.index != EXACT]

    def by_scenario(self, table: pd.DataFrame) -> pd.DataFrame:
        """A table of questions, indexed by their scenarios, as the bootstrap needs it."""
        first = self.rows.drop_duplicates("question").set_index("question")
        return table.set_axis(first["scenario"].reindex(table.index).to_numpy(), axis=0)


def once(compute: Callable[[Rows], T]) -> Callable[[Rows], T]:
    """The function, computed once for the same rows; nobody may change its result."""
    known: WeakKeyDictionary[Rows, T] = WeakKeyDictionary()

    @wraps(compute)
    def look_up(rows: Rows) -> T:
        if rows not in known:
            known[rows] = compute(rows)
        return known[rows]

    return look_up


# Columns that no comparison reads: every selection of rows would copy them.
_UNREAD = [column.name for column in ROW if column.detail]


@once
def compared(results: Results) -> Compared | None:
    """The attempts by which solvers are compared; None if there are none.

    Left out: attempts from another solver's path, and those of engines that are not installed or
    cannot read the question.
    """
    rows = results.rows.drop(columns=_UNREAD)
    kept = rows[(rows["initial_guess"] == "cold") & ~rows["outcome"].isin(_NEVER_SOLVED)]
    if kept.empty:
        return None
    by_presolve = presolved(kept)
    methods = methods_of(kept)
    stated = methods[["formulation", "engine", "guess"]]
    kept = kept.assign(
        question=kept.groupby(list(TRIAL), observed=True, sort=False).ngroup(),
        scenario=pd.factorize(kept["scenario_id"])[0],
        right=kept["verdict"].isin(SUCCESSES).fillna(False).astype(bool) & ~by_presolve,
        presolved=by_presolve,
        stratum=kept["label"].fillna(""),
        **{str(name): kept["solver"].map(values) for name, values in stated.items()},
    )
    strata = tuple(stratum_order(results, kept["stratum"]))
    return Compared(kept, methods, _limit(results, kept), strata)


def stratum_order(results: Results, labels: Iterable[str]) -> list[str]:
    """Distinct labels of scenarios, in the order in which the experiments' files name them."""
    text = "\n".join(folder.manifest.experiment.text for folder in results.folders)
    places = {name: text.find(json.dumps(name)) for name in sorted(set(labels))}
    return sorted(places, key=lambda name: (places[name] < 0, places[name]))


def _limit(results: Results, rows: pd.DataFrame) -> float:
    """The largest time limit of the runs; if none is stated, the longest attempt's time (s)."""
    limits = [folder.manifest.time_limit_s or 0.0 for folder in results.folders]
    if stated := [limit for limit in limits if 0 < limit < np.inf]:
        return float(max(stated))
    longest = float(rows["wall_s"].max())
    return longest if longest > 0 else 1.0
