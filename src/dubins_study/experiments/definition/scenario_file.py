"""Scenarios listed in a CSV or Parquet file: read, and every wrong row named at once."""

from __future__ import annotations

import csv
import logging
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from dubins_study.experiments.definition.messages import Problem, refusal
from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.scenario import (
    COLUMNS,
    NUMBERS,
    Scenario,
    ScenarioError,
    check_frame,
    missing_columns,
)
from dubins_study.study.values import did_you_mean, nearest, plain, short

if TYPE_CHECKING:
    import pandas as pd

_LOG = logging.getLogger(__name__)
MOST_SCENARIOS = 1_000_000
_MOST_BYTES = 2**30
_DEFAULTS: dict[str, Any] = {"speed": 1.0, "label": ""}
_REQUIRED = [name for name in COLUMNS if name not in _DEFAULTS]
_EXPECTED = f"expected the columns {', '.join(_REQUIRED)} and, if wanted, {', '.join(_DEFAULTS)}"
# What pandas names an index without a name, such as that of a filtered frame.
_PANDAS_INDEX = "__index_level_"
_NO_INDEX = "leave it out with to_parquet(..., index=False)"
# Where a row stands, such as `line 7`, and its values by column.
_Row = tuple[str, dict[str, Any]]


class ScenarioFileError(ScenarioError):
    """A file of scenarios that cannot be used; names every line, column, value and rule."""


def read_scenarios(file: str | FilePath) -> pd.DataFrame:
    """The scenarios of a file, one row each, with the columns of `study.scenario.COLUMNS`.

    A CSV file is UTF-8 with commas and a line of column names. In both formats `speed` and `label`
    may be left out, a heading is in radians or a text such as `120deg`, and columns may come in any
    order.

    Args:
        file: a path ending in .csv or .parquet.

    Raises:
        ScenarioFileError: naming the file and every line with a column, a value, and what was
            expected; or why the file cannot be read.
    """
    place = FilePath(file)
    readers: dict[str, Callable[[FilePath], Iterator[_Row]]] = {
        ".csv": _csv_rows,
        ".parquet": _parquet_rows,
    }
    if place.suffix not in readers:
        raise ScenarioFileError(f"{file}: expected a name ending in .csv or .parquet")
    try:
        size = place.stat().st_size
        if size > _MOST_BYTES:
            raise ScenarioFileError(f"{file}: {size} bytes; expected at most {_MOST_BYTES}")
        rows = list(readers[place.suffix](place))
    except UnicodeError:
        raise ScenarioFileError(f"{file}: cannot be read: it is not UTF-8 text") from None
    except OSError as error:
        raise ScenarioFileError(f"{file}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if isinstance(error, ScenarioFileError):
            raise
        raise ScenarioFileError(f"{file}: cannot be read: {error}") from None
    if not rows:
        raise ScenarioFileError(f"{file}: no scenarios; expected a row each")
    frame = _checked(str(file), rows)
    if copies := int(frame.duplicated().sum()):
        _LOG.warning(
            "dubins-study: %s: of %d rows %d repeat an earlier one; each scenario is asked once",
            *(plain(str(file)), len(frame), copies),
        )
    return frame


def _checked(file: str, rows: list[_Row]) -> pd.DataFrame:
    """The rows as a checked frame.

    Raises:
        ScenarioFileError: naming all rows that are not valid.
    """
    import pandas as pd

    try:
        columns: dict[str, list[Any]] = {
            name: [_number(name, values.get(name, _DEFAULTS.get(name))) for _, values in rows]
            for name in NUMBERS
        }
        columns["label"] = [values.get("label", "") for _, values in rows]
        return check_frame(pd.DataFrame(columns))
    except ScenarioError:
        pass  # the first mistake; all of them are looked for below
    problems = [
        Problem((), f"{where}: {sentence}") for where, values in rows for sentence in _wrong(values)
    ]
    raise ScenarioFileError(refusal(file, problems))


def _wrong(values: dict[str, Any]) -> list[str]:
    """What is wrong with a row, column by column."""
    sentences = []
    fields: dict[str, Any] = {"label": values.get("label", "")}
    for name in NUMBERS:
        try:
            fields[name] = _number(name, values.get(name, _DEFAULTS.get(name)))
            others: dict[str, Any] = {"target_x": 1.0, "target_y": 1.0}
            Scenario(**others | {name: fields[name]})  # this number by itself
        except ScenarioError as error:
            sentences.append(str(error))
    if not sentences:
        try:
            Scenario(**fields)
        except ScenarioError as error:  # the label, or all numbers together
            sentences.append(str(error))
    return sentences


def _number(name: str, value: Any) -> float:
    """A number from a cell, which holds a text in a CSV file.

    Raises:
        ScenarioFileError: naming column, value and what was expected.
    """
    if value is None or value == "":
        raise ScenarioFileError(f"{name} is empty; expected a number")
    if not isinstance(value, str):
        return value  # type: ignore[no-any-return]  # `Scenario` checks it
    text = value.strip()
    if name == "heading":
        try:
            return parse_angle(text)
        except AngleError as error:
            raise ScenarioFileError(f"heading: {error}") from None
    try:
        if "_" in text:  # which Python takes within a number
            raise ValueError
        return float(text)
    except ValueError:
        raise ScenarioFileError(f"{name} is {short(value)}; expected a number") from None


def _csv_rows(file: FilePath) -> Iterator[_Row]:
    with file.open(encoding="utf-8-sig", newline="") as stream:
        reader = csv.reader(stream, strict=True)
        try:
            head = [name.strip() for name in next(reader, [])]
            _check_columns(str(file), head, "line 1")
            first, count = reader.line_num + 1, 0
            for cells in reader:
                where, first = f"line {first}", reader.line_num + 1
                if not cells:  # an empty line
                    continue
                count += 1
                _check_count(file, count)
                if len(cells) != len(head):
                    raise ScenarioFileError(
                        f"{file}: {where}: {len(cells)} values; expected {len(head)}, one a column"
                    )
                values = dict(zip(head, cells, strict=True))
                # what is left empty has its default
                yield where, {k: v for k, v in values.items() if v or k not in _DEFAULTS}
        except csv.Error as error:
            raise ScenarioFileError(f"{file}: line {reader.line_num}: {error}") from None


def _parquet_rows(file: FilePath) -> Iterator[_Row]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        content = pq.ParquetFile(file)
        head = content.schema_arrow.names
        _check_columns(str(file), head, "the file")
        _check_count(file, content.metadata.num_rows)
        number = 0
        for batch in content.iter_batches(batch_size=2**14):
            for values in batch.to_pylist():
                number += 1
                given = {k: v for k, v in values.items() if v is not None or k not in _DEFAULTS}
                yield f"row {number}", given
    except pa.ArrowException as error:
        first = str(error).partition("\n")[0]
        raise ScenarioFileError(f"{file}: cannot be read as Parquet: {first}") from None


def _check_columns(file: str, head: Sequence[str], where: str) -> None:
    """Refuse columns that are missing, unknown or twice there, all of them at once."""
    missing = [name for name in _REQUIRED if name not in head]
    sentences, meant = [], set()
    for name in dict.fromkeys(name for name in head if name not in COLUMNS):
        if name.startswith(_PANDAS_INDEX):
            sentences.append(f"column {short(name)} is the index of a pandas frame; {_NO_INDEX}")
            continue
        absent = [*missing, *(n for n in _DEFAULTS if n not in head)]
        meant.add(nearest(name, absent))
        near = did_you_mean(name, absent)
        sentences.append(f"unknown column {short(name)}; {near}{_EXPECTED}")
    if lacking := [name for name in missing if name not in meant]:
        sentences.append(f"{missing_columns(lacking)}; {_EXPECTED}")
    twice = dict.fromkeys(name for name in head if name in COLUMNS and head.count(name) > 1)
    sentences += [f"column {name!r} appears twice" for name in twice]
    if len(head) == 1 and ";" in head[0]:
        sentences = ["the columns are separated by semicolons; expected commas"]
    if sentences:
        problems = [Problem((), f"{where}: {sentence}") for sentence in sentences]
        raise ScenarioFileError(refusal(file, problems))


def _check_count(file: FilePath, count: int) -> None:
    if count > MOST_SCENARIOS:
        raise ScenarioFileError(f"{file}: more than {MOST_SCENARIOS} scenarios; expected fewer")
