"""Scenarios of a CSV or Parquet file.

They are read, and checked row by row.
"""

from __future__ import annotations

import json
import logging
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.definition.messages import Problem, refusal
from dubins_study.experiments.definition.table_file import (
    Table,
    TableFileError,
    note_passed_over,
    read_table,
)
from dubins_study.study.scenario import COLUMNS, DEFAULTS, TOUR, VIA, Scenario, ScenarioError
from dubins_study.study.scenario_frame import scenario_column_problems, scenario_of
from dubins_study.study.units import doubtful_units
from dubins_study.study.values import nearest, number_of_text, plain, short

_LOG = logging.getLogger(__name__)
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
# in any other column an empty cell is refused: a measurement is missing
_MAY_BE_EMPTY = ("speed", "label", *VIA, "final_heading", *TOUR, "target_x", "target_y")


def read_scenarios(file: str | FilePath) -> list[Scenario]:
    """The scenarios of a file, one of each row.

    The columns of `study.scenario.DEFAULTS` may be left out, and cells of `_MAY_BE_EMPTY` may be
    empty. `via_x` and `via_y` hold lists of numbers; in a CSV file a text such as `4 6`. The error
    names the file and the first mistake of every line: column, value and what was expected.
    """
    place = FilePath(file)
    if place.suffix not in (".csv", ".parquet") or place.stem in (".", ".."):
        # the results folder is named after the stem
        raise TableFileError(f"{file}: expected a name ending in .csv or .parquet")
    table = read_table(place)
    passed_over = _check_columns(str(file), table)
    scenarios: list[Scenario] = []
    sentences = list(table.problems)
    for row in table.rows:
        try:
            scenarios.append(scenario_of({name: _value(name, row.values) for name in COLUMNS}))
        except ScenarioError as error:
            sentences.append(f"{row.place}: {error}")
    if not (scenarios or sentences):
        sentences = ["no scenarios; expected a row each"]
    _refuse(str(file), sentences)
    note_passed_over(place, passed_over)
    _note_slips(str(file), scenarios)
    return scenarios


def _refuse(file: str, sentences: list[str]) -> None:
    """Refuse a file if there are sentences about mistakes."""
    if sentences:
        raise TableFileError(refusal(file, [Problem((), sentence) for sentence in sentences]))


def _check_columns(file: str, table: Table) -> list[str]:
    """Refuse wrong columns; return the unrelated ones.

    An unrelated column is unknown, and not named like a missing one. A column is wrong if it is
    missing, there twice, or unknown and named like a missing one.
    """
    names = table.names
    missing = [name for name in COLUMNS if name not in names]
    unrelated = [name for name in names if not (name in COLUMNS or nearest(name, missing))]
    sentences = scenario_column_problems([name for name in names if name not in unrelated])
    if len(names) == 1 and ";" in names[0]:
        sentences = ["the columns are separated by semicolons; expected commas"]
    _refuse(file, sentences)
    return unrelated


def _note_slips(file: str, scenarios: list[Scenario]) -> None:
    """Warn of rows that repeat, and of doubtful units.

    Such rows are valid, but may be slips.
    """
    count = len(scenarios)
    remarks = []
    if copies := count - len(set(scenarios)):
        remarks.append(
            f"of {count} rows {copies} repeat an earlier one; each scenario is asked once"
        )
    doubts = list(filter(None, map(doubtful_units, scenarios)))
    if doubts:
        remarks.append(f"in {len(doubts)} of {count} rows {doubts[0]}")
    for remark in remarks:
        _LOG.warning("dubins-study: %s: %s", plain(file), remark)


def _value(name: str, row: dict[str, Any]) -> Any:
    """The value of a row's cell, or its default.

    `row` has texts if the file is CSV: numbers among them are read here. A heading stays a text.
    An empty cell is refused in a column that may not be empty.
    """
    value = row.get(name)
    if value is None or value == "":
        if name not in row or name in _MAY_BE_EMPTY:
            return DEFAULTS.get(name)
        raise TableFileError(f"{name} is empty; expected a number")
    if name.endswith("heading"):
        # as a text, so that `Scenario` refuses 90 without a unit; 90.0 would pass as radians
        return str(value)
    if name == "closed" and value in _FLAGS:
        return _FLAGS[value]
    if name in ("label", *VIA, *TOUR) or not isinstance(value, str):
        return value  # `Scenario` checks it
    try:
        return number_of_text(value)
    except ValueError:
        raise TableFileError(f"{name} is {short(value)}; expected a number") from None


def text_about(scenarios: str) -> tuple[str, str, str]:
    """Name, path and text of an experiment about scenarios.

    The three values are like those of `text_of`. The TOML text has a title and a question, but no
    solvers and no scenarios. `scenarios` is the file's path.
    """
    name = FilePath(scenarios).stem
    keys = {
        "title": f"Scenarios of {name}",
        "question": "How well do the chosen solvers answer these scenarios?",
    }
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
    return name, scenarios, text
