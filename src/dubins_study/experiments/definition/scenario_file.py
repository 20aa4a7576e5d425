"""Scenarios listed in a CSV or Parquet file: read, and checked row by row."""

from __future__ import annotations

import csv
import hashlib
import json
import logging
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from dubins_study.experiments.definition.messages import Problem, refusal
from dubins_study.study.scenario import COLUMNS, DEFAULTS, NUMBERS, VIA, Scenario, ScenarioError
from dubins_study.study.scenario_frame import column_problems, numbers_of, scenario_of
from dubins_study.study.units import doubtful_units
from dubins_study.study.values import nearest, number_of_text, plain, short

_LOG = logging.getLogger(__name__)
MOST_SCENARIOS = 1_000_000
# of other columns an empty cell is a measurement that is missing
_MAY_BE_EMPTY = ("speed", "label", *VIA, "final_heading")
_OPEN_QUOTE = "expected each row on a line of its own: is a quotation mark left open?"
# Where a row stands, such as `line 7`, and its values by column.
_Row = tuple[str, dict[str, Any]]


class ScenarioFileError(ScenarioError):
    """A file of scenarios that cannot be used; names every line, column, value and rule."""


def read_scenarios(file: str | FilePath) -> list[Scenario]:
    """The scenarios of a file, one of each row.

    The columns of `study.scenario.DEFAULTS` may be left out, and cells of `_MAY_BE_EMPTY` may be
    empty. `via_x` and `via_y` hold lists of numbers; in a CSV file a text such as `4 6`. The error
    names the file and every line with a column, a value and what was expected.
    """
    place = FilePath(file)
    read = {".csv": _csv_rows, ".parquet": _parquet_rows}.get(place.suffix)
    if read is None or place.stem in (".", ".."):  # the results folder is named after the stem
        raise ScenarioFileError(f"{file}: expected a name ending in .csv or .parquet")
    try:
        rows, problems = read(place)
    except ScenarioFileError:
        raise
    except OSError as error:
        raise ScenarioFileError(f"{file}: cannot be read: {error.strerror or error}") from None
    except UnicodeError:
        raise ScenarioFileError(f"{file}: cannot be read: it is not UTF-8 text") from None
    except ValueError as error:  # the Parquet reader's own words
        first = plain(str(error).partition("\n")[0])
        raise ScenarioFileError(f"{file}: cannot be read: {first}") from None
    if not problems and not 0 < len(rows) <= MOST_SCENARIOS:
        found = f"more than {MOST_SCENARIOS} scenarios; expected fewer"
        raise ScenarioFileError(f"{file}: {found if rows else 'no scenarios; expected a row each'}")
    scenarios = _scenarios(str(file), rows, problems)
    for remark in _remarks(scenarios):
        _LOG.warning("dubins-study: %s: %s", plain(str(file)), remark)
    return scenarios


def _scenarios(file: str, rows: list[_Row], problems: list[Problem]) -> list[Scenario]:
    """The scenarios of the rows; those that are not valid are refused with earlier problems."""
    scenarios: list[Scenario] = []
    for place, row in rows:
        try:
            scenarios.append(scenario_of({name: _value(name, row) for name in COLUMNS}))
        except ScenarioError:  # the first mistake of this row; all of them are looked for
            problems += [Problem((), f"{place}: {sentence}") for sentence in _wrong(row)]
    if problems:
        raise ScenarioFileError(refusal(file, problems))
    return scenarios


def _remarks(scenarios: list[Scenario]) -> Iterator[str]:
    """What may be a slip in valid rows: rows that repeat, and doubtful units."""
    if copies := len(scenarios) - len(set(scenarios)):
        yield (
            f"of {len(scenarios)} rows {copies} repeat an earlier one; each scenario is asked once"
        )
    doubts = [doubt for each in scenarios if (doubt := doubtful_units(each))]
    if doubts:
        yield f"in {len(doubts)} of {len(scenarios)} rows {doubts[0]}"


def _wrong(row: dict[str, Any]) -> list[str]:
    """What is wrong with a row: column by column, or else with all numbers together."""
    sentences = []
    fields: dict[str, Any] = {}
    for name in COLUMNS:
        try:
            fields[name] = _value(name, row)
            if name in VIA:
                numbers_of(name, fields[name])
            else:
                Scenario(**{"target_x": 1.0, "target_y": 1.0, name: fields[name]})
        except ScenarioError as error:
            sentences.append(str(error))
    if not sentences:
        try:
            scenario_of(fields)
        except ScenarioError as error:
            sentences.append(str(error))
    return sentences


def _value(name: str, row: dict[str, Any]) -> Any:
    """The value of a column, which is a text in a CSV file; its default where there is none."""
    value = row.get(name)
    if value is None or value == "":
        if name not in row or name in _MAY_BE_EMPTY:
            return DEFAULTS[name]
        raise ScenarioFileError(f"{name} is empty; expected a number")
    if name.endswith("heading"):
        return str(value)  # also of a number, which is refused beyond a full turn if it is a text
    if name in ("label", *VIA) or not isinstance(value, str):
        return value  # `Scenario` checks it
    try:
        return number_of_text(value)
    except ValueError:
        raise ScenarioFileError(f"{name} is {short(value)}; expected a number") from None


def _csv_rows(file: FilePath) -> tuple[list[_Row], list[Problem]]:
    """The rows as texts, each with its line, and a problem for each line that is no row."""
    rows: list[_Row] = []
    problems: list[Problem] = []
    with file.open(encoding="utf-8-sig", newline="") as text:
        lines = _cells_of_lines(file, text)
        head = [name.strip() for name in next(lines, (1, 1, []))[2]]
        if not head:
            raise ScenarioFileError(f"{file}: line 1 is empty; expected the names of the columns")
        _check_columns(file, head, "line 1")
        for first_line, last_line, cells in lines:
            place = f"line {first_line}"
            if last_line > first_line:
                sentence = f"{place}: a text goes on to line {last_line}; {_OPEN_QUOTE}"
                problems.append(Problem((), sentence))
            elif len(cells) > len(head):
                sentence = f"{place}: {len(cells)} cells; expected {len(head)}, as in line 1"
                problems.append(Problem((), sentence))
            elif any(cells):  # no empty line
                cells += [""] * (len(head) - len(cells))
                rows.append((place, dict(zip(head, cells, strict=True))))
    return rows, problems


def _cells_of_lines(file: FilePath, text: Iterable[str]) -> Iterator[tuple[int, int, list[str]]]:
    """The first line, the last line and the cells of each row."""
    reader = csv.reader(text, strict=True)
    first_line = 1
    try:
        for cells in reader:
            yield first_line, reader.line_num, cells
            first_line = reader.line_num + 1
    except csv.Error as error:
        raise ScenarioFileError(f"{file}: line {first_line}: {error}; {_OPEN_QUOTE}") from None


def _parquet_rows(file: FilePath) -> tuple[list[_Row], list[Problem]]:
    import pyarrow.parquet as pq

    with pq.ParquetFile(file) as content:
        _check_columns(file, content.schema_arrow.names, "the file")
        rows = content.read().to_pylist()
    return [(f"row {number}", row) for number, row in enumerate(rows, 1)], []


def _check_columns(file: FilePath, head: Sequence[str], where: str) -> None:
    """Refuse columns that are missing, twice there, or unknown and named like a missing one."""
    missing = [name for name in COLUMNS if name not in head]
    others = [name for name in head if not (name in COLUMNS or nearest(name, missing))]
    sentences = column_problems([name for name in head if name not in others])
    if len(head) == 1 and ";" in head[0]:
        sentences = ["the columns are separated by semicolons; expected commas"]
    if sentences:
        problems = [Problem((), f"{where}: {sentence}") for sentence in sentences]
        raise ScenarioFileError(refusal(str(file), problems))
    if others:
        shown = plain(f"{file}: passed over, since rows have no such column: {', '.join(others)}")
        _LOG.warning("dubins-study: %s", shown)


def text_about(scenarios: str) -> tuple[str, str, str]:
    """The experiment (as `text_of`) that asks about a file of scenarios; it names no solvers."""
    name = FilePath(scenarios).stem
    question = "How well do the chosen solvers answer these scenarios?"
    keys = {"title": f"Scenarios of {name}", "question": question}
    return name, scenarios, "".join(f"{key} = {json.dumps(text)}\n" for key, text in keys.items())


_numbers = attrgetter(*NUMBERS)
_route = attrgetter("via", "final_heading")


def comment_on(scenarios: list[Scenario]) -> str:
    """A comment that tells scenarios apart, since a folder with rows about others is another's."""
    digest = hashlib.sha256(np.array([_numbers(each) for each in scenarios]).tobytes())
    digest.update("\0".join(each.label for each in scenarios).encode())
    if not all(each.one_free_leg for each in scenarios):
        digest.update(repr([_route(each) for each in scenarios]).encode())
    return f"# about {len(scenarios)} scenarios with the digest {digest.hexdigest()[:16]}\n"
