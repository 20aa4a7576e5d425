"""Select the rows that count from several folders.

They are of current code, and each cell has one row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.report.data.attempts import Mask
from dubins_study.study.kinds.table import kind_of
from dubins_study.study.rows.manifest import Manifest
from dubins_study.study.rows.repeated import JUDGED, compare_attempts, differences
from dubins_study.study.rows.schema import CELL, names
from dubins_study.study.scenario import COLUMNS
from dubins_study.study.scenario_frame import scenario_of

_CELL = ["experiment", *names(CELL)]
_QUESTION = ["experiment", "scenario_id", "branch"]
_READ = [*names(CELL), "code_digest", *JUDGED, "gap", "reference_word", "region", *COLUMNS]
_READ += ["wall_s", "limit_s", "machine"]


class RowCounts(NamedTuple):
    """The counts of one folder's rows."""

    current: int = 0  # of the current code, counted in the report or not
    stale: int = 0  # of earlier code, or of a solver that the manifest does not name
    replaced: int = 0  # of cells that an earlier folder holds with other code
    # of cells that an earlier folder holds with this code and another result
    contradicting: int = 0
    # of questions that an earlier folder asks with another time limit
    other_limits: int = 0

    @property
    def limits_text(self) -> str:
        """A warning that counts the questions with other limits.

        It stands behind the folder's name and is true only if `other_limits` is not 0.
        """
        return (
            f"{self.other_limits} of its questions have another time limit in a folder before it; "
            "do not compare answers that were given different times"
        )


def select_attempts(
    tables: Sequence[pa.Table], manifests: Sequence[Manifest]
) -> tuple[pa.Table, list[RowCounts]]:
    """The rows that count, and each folder's counts.

    The tables have the folders' rows. Where two folders hold the same cell, the earlier one's row
    counts. Where `limit_s` is missing, it is the manifest's. Five columns are added:

    experiment: its name;
    answerable: whether the question has an answer and is not open;
    left_open: whether the check could not decide an answer to the question. No attempt at it
        counts, since a good answer could not be told from a bad one;
    late: whether the attempt took longer than its limit. It is then a failure, whatever it
        answered, in shares and in means alike;
    elsewhere: whether it was made on another machine than most rows of its experiment's first
        folder. Times of one suite are compared with each other, and suites may be of several
        machines.
    """
    stored = pa.concat_tables(tables)
    rows = stored.select([*dict.fromkeys(_READ)]).to_pandas()
    rows["folder"] = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    experiments = {n: manifest.experiment.name for n, manifest in enumerate(manifests)}
    rows["experiment"] = rows["folder"].map(experiments)
    current = _is_current(rows, manifests)
    current_places = np.flatnonzero(current)
    # `first`: positions of each cell's first row; `pairs`: later rows of a cell beside its first.
    first, pairs = compare_attempts(rows.iloc[current_places], _CELL)
    places = current_places[first]
    counted = stored.take(places)
    first_rows = rows.iloc[places]
    limit_of_folder = {n: manifest.time_limit_s or np.nan for n, manifest in enumerate(manifests)}
    limits = first_rows["limit_s"].fillna(first_rows["folder"].map(limit_of_folder))
    for name, values in _added_columns(first_rows, limits).items():
        counted = counted.append_column(name, pa.array(values, from_pandas=True))
    place = counted.schema.get_field_index("limit_s")
    filled = pa.array(limits, pa.float64(), from_pandas=True)
    counted = counted.set_column(place, counted.schema.field(place), filled)
    sections = {n: manifest.experiment.section for n, manifest in enumerate(manifests)}
    of_rows = first_rows["folder"].map(sections)
    differ = _other_limits(first_rows.assign(limit_s=limits, section=of_rows))
    return counted, [
        _row_counts(
            current[rows["folder"] == n],
            pairs[pairs["folder"] == n],
            manifest.gap_tolerance,
            other_limits=int(differ.get(n, 0)),
        )
        for n, manifest in enumerate(manifests)
    ]


def _added_columns(rows: pd.DataFrame, limits: pd.Series[float]) -> dict[str, pd.Series]:
    """The columns that `select_attempts` adds.

    `limits` are the time limits of the rows, s.
    """
    machines = rows["experiment"].map(_own_machines(rows))
    undecided = rows["verdict"].eq("undecided")
    # One undecided attempt opens the question for all solvers.
    left_open = undecided.groupby([rows[name] for name in _QUESTION]).transform("any")
    return {
        "experiment": rows["experiment"],
        "answerable": _answerable(rows) & ~left_open,
        "left_open": left_open,
        "late": rows["wall_s"] > limits,
        "elsewhere": rows["machine"].notna() & rows["machine"].ne(machines),
    }


def _own_machines(rows: pd.DataFrame) -> dict[str, str | None]:
    """The machine that each experiment's times count from.

    It made most rows of the first folder that holds the experiment; None if these rows name no
    machine.
    """
    first = rows["folder"] == rows.groupby("experiment")["folder"].transform("min")
    modes = {str(name): part.mode() for name, part in rows[first].groupby("experiment")["machine"]}
    return {name: next(iter(mode), None) for name, mode in modes.items()}


def _other_limits(rows: pd.DataFrame) -> pd.Series[int]:
    """The number of questions with another limit, by folder.

    A question counts if an earlier folder asked it with another time limit. Two suites with
    different sections are not compared, so their limits may differ.
    """
    questions = rows.drop_duplicates(["folder", "scenario_id", "branch", "limit_s"])
    columns = ["folder", "limit_s", "section"]
    first = questions.groupby(["scenario_id", "branch"])[columns].transform("first")
    apart = questions["section"].ne(first["section"])
    apart &= questions["section"].notna() & first["section"].notna()
    # `first`: the values of the earliest folder that asks the question and states them.
    later = (questions["folder"] > first["folder"]) & ~apart
    other = questions[later & (questions["limit_s"] != first["limit_s"]) & first["limit_s"].notna()]
    return other.drop_duplicates(["folder", "scenario_id", "branch"]).groupby("folder").size()


def _is_current(rows: pd.DataFrame, manifests: Sequence[Manifest]) -> Mask:
    """A mask of the rows made by current code.

    The manifest of the row's folder names the current code digest of each solver; `status` compares
    the same.
    """
    named: list[tuple[int, str, str]] = []
    for folder, manifest in enumerate(manifests):
        named += [(folder, *entry) for entry in manifest.code_digests.items()]
    code = pd.MultiIndex.from_frame(rows[["folder", "solver", "code_digest"]])
    return pd.Series(code.isin(named), rows.index)


def _row_counts(
    current: Mask, pairs: pd.DataFrame, gap_tolerance: float, other_limits: int
) -> RowCounts:
    """The counts of one folder's rows.

    `current` masks the folder's rows of current code. `pairs` are its rows that an earlier row of
    the cell replaces, beside that row (`compare_attempts`).
    """
    other_code = pairs["code_digest"] != pairs["code_digest_kept"]
    differ = differences(pairs, gap_tolerance).any(axis="columns")
    return RowCounts(
        current=int(current.sum()),
        stale=int((~current).sum()),
        replaced=int(other_code.sum()),
        contradicting=int((differ & ~other_code).sum()),
        other_limits=other_limits,
    )


def _answerable(rows: pd.DataFrame) -> Mask:
    """A mask of rows whose question has an answer.

    A judged row has a reference word exactly if its question has an answer. For a row that was not
    judged, the kind of the question decides (`_has_answer`): a leg by the closed form. Every route
    has an answer. A leg with a final heading has one for `best`, and for the words that reach every
    pose.
    """
    judged = rows["reference_word"].notna()
    unjudged = rows[~judged & rows["region"].isna()]
    answerable = [
        place
        for place, row in zip(unjudged.index, unjudged.to_dict("records"), strict=True)
        if _has_answer(row)
    ]
    return judged | rows.index.isin(answerable)


def _has_answer(row: Mapping[Any, Any]) -> bool:
    scenario = scenario_of(row)
    branch = row["branch"]
    kind = kind_of(scenario, branch)
    return branch in kind.branches and kind.exists(scenario, branch)
