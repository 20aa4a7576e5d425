"""Scenarios listed in a CSV or Parquet file: read, checked row by row, made an experiment."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from dubins_study.experiments.definition.experiment import (
    ExperimentError,
    ExperimentFile,
    validated,
)
from dubins_study.experiments.definition.messages import Problem, refusal
from dubins_study.experiments.definition.scenario_block import ListedBlock
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
    order. The error names the file and every line with a column, a value and what was expected.
    """
    place = FilePath(file)
    read = {".csv": _csv_rows, ".parquet": _parquet_rows}.get(place.suffix)
    if read is None:
        raise ScenarioFileError(f"{file}: expected a name ending in .csv or .parquet")
    try:
        size = place.stat().st_size
        if size > _MOST_BYTES:
            raise ScenarioFileError(f"{file}: {size} bytes; expected at most {_MOST_BYTES}")
        rows = read(place)
    except ScenarioFileError:
        raise
    except UnicodeError:
        raise ScenarioFileError(f"{file}: cannot be read: it is not UTF-8 text") from None
    except OSError as error:
        raise ScenarioFileError(f"{file}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # the parser's own words
        first = plain(str(error).partition("\n")[0])
        raise ScenarioFileError(f"{file}: cannot be read: {first}") from None
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
    """The rows as a checked frame; all rows that are not valid are refused together."""
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
    """A number from a cell, which holds a text in a CSV file."""
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


def _csv_rows(file: FilePath) -> list[_Row]:
    """The rows as texts, each with its line; of a quoted text with line breaks, the first line."""
    import pandas as pd

    cells = pd.read_csv(
        file,
        header=None,
        dtype=str,
        keep_default_na=False,
        skip_blank_lines=False,
        encoding="utf-8-sig",
    ).fillna("")
    breaks = cells.apply(lambda column: column.str.count("\n")).sum(axis="columns")
    lines = 1 + cells.index + breaks.cumsum().shift(fill_value=0)
    head, *rows = cells.to_numpy().tolist()
    head = [name.strip() for name in head]
    _check_columns(str(file), head, "line 1")
    _check_count(file, sum(map(any, rows)))
    return [
        (f"line {line}", {k: v for k, v in zip(head, row, strict=True) if v or k not in _DEFAULTS})
        for line, row in zip(lines[1:], rows, strict=True)
        if any(row)  # no empty line
    ]


def _parquet_rows(file: FilePath) -> list[_Row]:
    import pyarrow.parquet as pq

    with pq.ParquetFile(file) as content:
        _check_columns(str(file), content.schema_arrow.names, "the file")
        _check_count(file, content.metadata.num_rows)
        rows = content.read().to_pylist()
    return [
        (f"row {n}", {k: v for k, v in row.items() if v is not None or k not in _DEFAULTS})
        for n, row in enumerate(rows, 1)
    ]


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


def listed_experiment(
    scenarios: str, base: ExperimentFile | None, solvers: list[str] | None
) -> ExperimentFile:
    """The experiment that asks solvers about the scenarios of a file.

    The branches and limits of `base` hold, and its solvers, unless others are named.
    """
    frame = read_scenarios(scenarios)
    name = FilePath(scenarios).stem
    if name in (".", ".."):  # the results folder has this name
        raise ExperimentError(f"{scenarios}: expected a file with a name, such as drive.csv")
    digest = hashlib.sha256(frame[list(NUMBERS)].to_numpy().tobytes())
    digest.update("\0".join(frame["label"]).encode())
    # A folder that holds rows about other scenarios is another experiment.
    comment = f"# about {len(frame)} scenarios with the digest {digest.hexdigest()[:16]}\n"
    if base is None:
        question = "How well do the chosen solvers answer these scenarios?"
        keys = {"title": f"Scenarios of {name}", "question": question}
        text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
        fields: dict[str, Any] = {**keys, "solvers": solvers}
    else:
        title = f"{base.experiment.title}: scenarios of {name}"
        text, fields = base.text, dict(base.experiment)
        fields |= {"title": title, "first": None, "section": None, "matrix": False}
    block = ListedBlock(listed=frame)
    experiment = validated(scenarios, fields | {"scenarios": [block]})
    return ExperimentFile(name, scenarios, comment + text, experiment)
