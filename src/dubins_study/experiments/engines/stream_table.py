"""One chunk of a stream: scenarios as columns in, judged rows out, as the schema has them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.experiments.engines.judging import shared
from dubins_study.experiments.plan.block_columns import Columns
from dubins_study.experiments.plan.scenario_ids import scenario_ids
from dubins_study.experiments.provenance import now, versions
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.solvers.registry import load
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import SCENARIO, names


def chunk_table(
    columns: Columns, label: str, key: Mapping[str, Any], run: RunSettings, proved: bool
) -> pa.Table:
    """The rows of a chunk; every row's times are the chunk's divided by its size.

    Texts are dictionaries: a column that holds one text everywhere costs next to nothing.

    Args:
        columns: scenarios, n of them.
        label: of all of them.
        key: the columns of the key but `scenario_id`, one value for all.
        run: what the rows of the run share.
        proved: whether to enclose every reference length.
    """
    n, started = len(columns["x"]), now()
    answers = _answers(columns, key, run, proved)
    own = [name for name in answers.columns if name not in names(SCENARIO)]
    table = pa.Table.from_pandas(answers[own], preserve_index=False)
    by_name: dict[str, Any] = {name: table[name] for name in own}
    by_name |= {name: pa.array(values) for name, values in columns.items()}
    by_name["scenario_id"] = scenario_ids(columns, label)
    same = {**key, "label": label, **shared(run, started, _versions(key["solver"]))}
    by_name |= {name: _repeated(value, n) for name, value in same.items()}
    arrays = [_as_written(by_name[field.name], field.type) for field in ARROW_SCHEMA]
    return pa.Table.from_arrays(arrays, names=ARROW_SCHEMA.names)


def warm_up(columns: Columns, key: Mapping[str, Any], run: RunSettings) -> None:
    """Solve a chunk and record nothing: what is compiled meanwhile is not the solver's time."""
    _answers(columns, key, run, proved=False)


def _answers(
    columns: Columns, key: Mapping[str, Any], run: RunSettings, proved: bool
) -> pd.DataFrame:
    from dubins_study.solvers.frame import solve_frame

    return solve_frame(
        pd.DataFrame(columns, copy=False),
        solver=key["solver"],
        branch=key["branch"],
        profile=key["profile"],
        limit=run.time_limit_s,
        certified=True,
        enclosed=proved,
    )


def _versions(spec: str) -> str:
    return json.dumps(versions(tuple(load(spec).packages)))


def _repeated(value: Any, n: int) -> pa.Array:
    if isinstance(value, str):
        codes = pa.array(np.zeros(n, np.int8))
        return pa.DictionaryArray.from_arrays(codes, pa.array([value], pa.string()))
    return pa.repeat(value, n)


def _as_written(column: Any, kind: pa.DataType) -> Any:
    """A column of the schema's type, its texts as a dictionary; what is not finite is null."""
    if pa.types.is_dictionary(column.type):
        return column
    if pa.types.is_float64(kind) and column.type == kind:
        finite = pc.is_finite(column)
        return column if pc.all(finite).as_py() else pc.if_else(finite, column, None)
    return column if column.type == kind else column.cast(kind)
