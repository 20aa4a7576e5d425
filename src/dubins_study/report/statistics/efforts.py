"""What evaluations and seconds of an answer go to: its winning run, other runs, building."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.statistics.compared import Compared
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import COLUMNS, Scenario
from dubins_study.study.words import BRANCHES

# What evaluations and seconds go to. The run that gave the answer is the floor: the engine called
# once, from that guess. Restarts are the other runs on the same subproblem. Other subproblems have
# a path that loses, or no path. The rest lies outside the subproblems, e.g. polishing the answer.
KINDS = ("winning run", "restarts", "losing words", "words without a path", "building", "rest")
AMOUNTS = {"evaluations": "subproblem_evaluations", "seconds": "subproblem_s"}
_RELATIVE_ROUNDING = 1e-9
_READ = [
    *("solver", "question", "scenario", "stratum", "word", "evaluations", "build_s", "wall_s"),
    *("subproblems", "subproblem_evaluations", "subproblem_s"),
    *("best_run_evaluations", "best_run_s", *COLUMNS),
]


class Split(NamedTuple):
    """Right answers at questions with a path, and what each cost; three frames of one index.

    `answers` has the columns solver, question and stratum, and a row per attempt; the others have
    the columns `KINDS` and total (of the whole attempt), NaN where the engine does not count.
    """

    answers: pd.DataFrame
    evaluations: pd.DataFrame
    seconds: pd.DataFrame

    def amount(self, name: str) -> pd.DataFrame:
        """The evaluations or the seconds."""
        return self.evaluations if name == "evaluations" else self.seconds

    def medians(self, values: pd.Series[float]) -> pd.DataFrame:
        """A value of each answer as a table: questions by solvers, the median over repeats."""
        return values.groupby([self.answers["question"], self.answers["solver"]]).median().unstack()


def split(compared: Compared) -> Split:
    """What the right answers cost; answers whose winning run is not known are left out."""
    rows = compared.answerable
    rows = rows.loc[rows["right"] & (rows["best_run_s"] > 0), _READ]
    lines = _lines(rows)
    kinds = _kinds(lines, rows)
    return Split(
        rows[["solver", "question", "stratum"]],
        _parts(rows, lines, kinds, "evaluations"),
        _parts(rows, lines, kinds, "seconds"),
    )


def _parts(
    rows: pd.DataFrame, lines: pd.DataFrame, kinds: pd.Series[Any], amount: str
) -> pd.DataFrame:
    """Each attempt's evaluations or seconds, by kind, and their total."""
    summed = lines[amount].groupby([lines["row"], kinds]).sum(min_count=1).unstack()
    parts = summed.reindex(index=rows.index, columns=list(KINDS)).fillna(0.0)
    known = summed.sum(axis=1).reindex(rows.index).fillna(0.0)
    if amount == "evaluations":
        best, total = rows["best_run_evaluations"], rows["evaluations"]
        parts["building"] = 0.0
    else:
        best, total = rows["best_run_s"], rows["wall_s"]
        parts["building"] = rows["build_s"].fillna(0.0)
    parts["winning run"] = best
    parts["restarts"] = (parts["restarts"] - best).clip(lower=0.0)
    counted = parts.drop(columns="rest").sum(axis=1, skipna=False)
    parts["total"] = np.fmax(total.fillna(known), counted)
    parts["rest"] = parts["total"] - counted
    return parts.where(best > 0).astype(np.float64)


def _lines(rows: pd.DataFrame) -> pd.DataFrame:
    """One line per attempt and subproblem: row, subproblem, evaluations, seconds.

    Attempts whose lists of subproblems differ in length have no lines.
    """
    names = rows["subproblems"].fillna("").map(str.split)
    sizes = names.map(len)
    for column in AMOUNTS.values():
        sizes = sizes.where(sizes == rows[column].map(_size), 0)
    kept = sizes[sizes > 0].astype(int)
    chain = itertools.chain.from_iterable
    frame = pd.DataFrame(
        {
            "row": np.repeat(kept.index.to_numpy(), kept.to_numpy()),
            "subproblem": list(chain(names[kept.index])),
        }
    )
    for amount, column in AMOUNTS.items():
        frame[amount] = np.array(list(chain(rows.loc[kept.index, column])), dtype=np.float64)
    return frame


def _size(value: object) -> int:
    return len(value) if isinstance(value, (list, np.ndarray)) else 0


def _kinds(lines: pd.DataFrame, rows: pd.DataFrame) -> pd.Series[Any]:
    """The kind of each line; the winner's line is `restarts`, its best run included."""
    if lines.empty:
        return pd.Series("", lines.index)
    attempts = rows[["word", "best_run_s", "scenario", *COLUMNS]].loc[lines["row"]]
    place, pairs = pd.factorize(
        pd.MultiIndex.from_arrays([attempts["word"].fillna("").to_numpy(), lines["subproblem"]])
    )
    misfit = np.array([not _contains(*pair) for pair in pairs])[place]
    best = attempts["best_run_s"].to_numpy()
    # The engine's time on the winner is at least that of its best run.
    too_short = lines["seconds"].to_numpy() < best * (1 - _RELATIVE_ROUNDING)
    order = pd.DataFrame(
        {"row": lines["row"], "too_short": too_short, "misfit": misfit, "s": lines["seconds"]}
    ).sort_values(["row", "too_short", "misfit", "s"], kind="stable")
    winner = np.zeros(len(lines), dtype=bool)
    winner[order.index[~order["row"].duplicated()]] = True
    exists = _exists(attempts, lines["subproblem"].to_numpy())
    names = np.where(winner, "restarts", np.where(exists, "losing words", KINDS[3]))
    return pd.Series(names, lines.index)


def _contains(word: str, subproblem: str) -> bool:
    """Whether a subproblem's letters, in order, include a path's word."""
    letters = iter(subproblem)
    return all(letter in letters for letter in word)


def _exists(attempts: pd.DataFrame, subproblems: FloatArray) -> FloatArray:
    """Whether each subproblem has a path; true of all that are no words, such as the joint model.

    The closed form decides, once for each scenario and word.
    """
    pairs = pd.MultiIndex.from_arrays([attempts["scenario"].to_numpy(), subproblems])
    place = pairs.factorize()[0]
    _, first = np.unique(place, return_index=True)
    columns: list[dict[Any, Any]] = attempts[list(COLUMNS)].iloc[first].to_dict("records")
    words = subproblems[first]
    known = [
        word not in BRANCHES or word == "best" or shortest(Scenario(**line), word) is not None
        for line, word in zip(columns, words, strict=True)
    ]
    every: FloatArray = np.array(known)[place]
    return every
