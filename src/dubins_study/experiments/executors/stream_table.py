"""Solve one chunk of a stream: take scenarios as columns, return judged rows as an Arrow table."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.experiments.executors.judging import run_columns
from dubins_study.experiments.plan.scenario_columns import Columns
from dubins_study.experiments.plan.scenario_ids import scenario_ids
from dubins_study.experiments.plan.streams import Stream
from dubins_study.experiments.provenance import now, versions
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.solvers.registry import load
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import SCENARIO, names


def chunk_table(columns: Columns, stream: Stream, settings: RunSettings) -> pa.Table:
    """The rows of a chunk, with the schema's columns.

    The times in each row are those of the whole chunk divided by its number of rows. Text columns
    are dictionary arrays: a column with the same text in every row then takes almost no memory.

    Args:
        columns: the scenarios, arrays of shape (n,).
    """
    n, started = len(columns["x"]), now()
    answers = _answers(columns, stream, settings)
    answer_names = [name for name in answers.columns if name not in names(SCENARIO)]
    table = pa.Table.from_pandas(answers[answer_names], preserve_index=False)
    by_name: dict[str, Any] = {name: table[name] for name in answer_names}
    by_name |= {name: pa.array(values) for name, values in columns.items()}
    by_name["scenario_id"] = scenario_ids(columns, stream.block.label)
    run_values = run_columns(settings, started, _versions(stream.solver))
    constants = {**stream.key_columns, "label": stream.block.label, **run_values}
    by_name |= {name: _repeated(value, n) for name, value in constants.items()}
    arrays = [_in_schema(by_name[field.name], field.type) for field in ARROW_SCHEMA]
    return pa.Table.from_arrays(arrays, names=ARROW_SCHEMA.names)


def warm_up(columns: Columns, stream: Stream, settings: RunSettings) -> None:
    """Solve a chunk without recording it: numba compiles its kernels during the first solve."""
    _answers(columns, stream, settings)


def _answers(columns: Columns, stream: Stream, settings: RunSettings) -> pd.DataFrame:
    from dubins_study.solvers.frame import solve_frame  # loads numba, which only streams need

    return solve_frame(
        pd.DataFrame(columns, copy=False),
        solver=stream.solver,
        branch=stream.branch,
        profile=stream.profile,
        limit=settings.time_limit_s,
        certified=True,
    )


def _versions(spec: str) -> str:
    return json.dumps(versions(tuple(load(spec).packages)))


def _repeated(value: Any, n: int) -> Any:
    """A column of n equal values."""
    if isinstance(value, str):
        codes: Any = pa.array(np.zeros(n, np.int8))
        return pa.DictionaryArray.from_arrays(codes, pa.array([value], pa.string()))
    return pa.repeat(value, n)


def _in_schema(column: Any, kind: pa.DataType) -> Any:
    """A column with the schema's type; dictionaries stay, non-finite numbers become null."""
    if pa.types.is_dictionary(column.type):
        return column
    if pa.types.is_float64(kind) and column.type == kind:
        finite = pc.is_finite(column)
        return column if pc.all(finite).as_py() else pc.if_else(finite, column, None)
    return column if column.type == kind else column.cast(kind)
