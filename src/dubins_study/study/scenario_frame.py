"""Scenarios as a frame, one row each: read from any columns, and checked."""

from __future__ import annotations

import math
import shlex
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from dubins_study.study.angle import LARGEST_BARE
from dubins_study.study.scenario import (
    COLUMNS,
    DEFAULTS,
    DEGREES,
    HEADINGS,
    LARGEST,
    LARGEST_EXTENT,
    NUMBERS,
    POSITIVE,
    SMALLEST,
    VIA,
    Scenario,
    ScenarioError,
    checked_number,
)
from dubins_study.study.values import did_you_mean, number_of_text, short

if TYPE_CHECKING:
    import pandas as pd

    from dubins_study.study.arrays import FloatArray


def column_problems(names: Sequence[Any]) -> list[str]:
    """What is wrong with the names of the columns of a table of scenarios, a sentence each."""
    required = [name for name in COLUMNS if name not in DEFAULTS]
    expected = f"expected the columns {', '.join(required)} and, if wanted, {', '.join(DEFAULTS)}"
    problems = []
    if missing := [name for name in required if name not in names]:
        several = "s" if len(missing) > 1 else ""
        problems.append(f"missing column{several} {', '.join(map(repr, missing))}; {expected}")
    for name in dict.fromkeys(names):
        if name not in COLUMNS:
            near = did_you_mean(name, [known for known in COLUMNS if known not in names])
            problems.append(f"unknown column {short(name)}; {near}{expected}")
        elif names.count(name) > 1:
            problems.append(f"column {name!r} appears twice")
    return problems


def check_frame(frame: pd.DataFrame) -> pd.DataFrame:
    """The frame with the columns of `COLUMNS` in order, float64 where they are numbers.

    Columns of `DEFAULTS` may be left out; a cell without a label, via points or a final heading may
    be empty. The caller's frame is not changed; its index is kept. Each value is read as `Scenario`
    takes it, or in `via_x` and `via_y` as `numbers_of` does; a column `via` of lists of pairs
    stands for both. A `ScenarioError` names columns, or the first row that no scenario may have. A
    heading beyond a full turn that is no text gives a warning, as a scenario's does.
    """
    import pandas as pd

    if not isinstance(frame, pd.DataFrame):
        raise ScenarioError(f"expected a DataFrame of scenarios, got {type(frame).__name__}")
    names = list(frame.columns)
    if problems := column_problems([name for name in names if name != "via"]):
        raise ScenarioError(problems[0])
    if "via" in names and {*VIA} & {*names}:
        raise ScenarioError("via points are given twice; expected via, or via_x and via_y")
    columns = _columns_of_numbers(frame) or _columns_row_by_row(frame)
    for name in {*HEADINGS} & {*names}:
        beyond = np.abs(columns[name]) > LARGEST_BARE
        if beyond.any() and not all(isinstance(angle, str) for angle in frame[name][beyond]):
            warnings.warn(f"{name} {DEGREES}", stacklevel=5)  # at the call of `solve_frame`
    return pd.DataFrame({name: columns[name] for name in COLUMNS}, frame.index, copy=False)


def _columns_of_numbers(frame: pd.DataFrame) -> dict[str, Any] | None:
    """The columns of one leg a row, each checked as a whole; None if rows are to be looked at."""
    n = len(frame)
    if not n or any(name in frame and not frame[name].isna().all() for name in ("via", *VIA)):
        return None
    columns: dict[str, Any] = {}
    for name in (*NUMBERS, "final_heading"):
        column = _doubles(frame, name)
        if column is None:
            return None
        columns[name] = column
    columns["label"] = _labels(frame) if "label" in frame else ""
    if columns["label"] is None:
        return None
    # of a row of the largest coordinates and the smallest radius of all, which few frames have
    places = [columns[name] for name in ("x", "y", "target_x", "target_y")]
    worst = sum(max(abs(place.min()), abs(place.max())) for place in places)
    if worst > LARGEST_EXTENT * columns["radius"].min():
        return None
    columns |= dict.fromkeys(VIA, nulls(n))
    return columns


def _doubles(frame: pd.DataFrame, name: str) -> FloatArray | None:
    """A column of numbers as doubles, read-only; None if one of them is refused, or is a text."""
    if name not in frame:
        default = DEFAULTS[name]
        # takes no memory
        return np.broadcast_to(math.nan if default is None else default, len(frame))
    if frame[name].dtype.kind not in "iuf":
        return None
    with np.errstate(over="ignore"):
        values = frame[name].to_numpy(dtype=np.float64, na_value=np.nan).view()
    values.flags.writeable = False  # whoever gets the frame may read it
    # min and max see NaN and both infinities without a temporary array of the frame's length
    low, high = values.min(), values.max()
    if name == "final_heading":  # free where it is NaN
        low, high = np.fmin.reduce(values, initial=1.0), np.fmax.reduce(values, initial=1.0)
    least = SMALLEST if name in POSITIVE else -LARGEST
    return values if least <= low and high <= LARGEST else None  # neither holds for NaN


def _labels(frame: pd.DataFrame) -> pd.Series[Any] | None:
    """The labels, if each is a text that a row can hold."""
    from pandas.api.types import infer_dtype

    labels = frame["label"]
    if infer_dtype(labels, skipna=False) != "string" or labels.isna().any():
        return None
    storable = (text == text.encode("utf-8", "ignore").decode() for text in labels.unique())
    return labels if all(storable) else None


def _columns_row_by_row(frame: pd.DataFrame) -> dict[str, Any]:
    """The columns of any frame; the first row that no scenario may have is refused."""
    import pandas as pd

    found = []
    for row, values in enumerate(frame.itertuples(index=False, name=None)):
        try:
            found.append(scenario_of(dict(zip(frame.columns, values, strict=True))))
        except ScenarioError as error:
            raise ScenarioError(f"{row_name(frame, row)}: {error}") from None
    columns = {name: [getattr(scenario, name) for scenario in found] for name in COLUMNS}
    arrays: dict[str, Any] = {
        name: np.array(columns[name], np.float64) for name in (*NUMBERS, "final_heading")
    }
    lists = {name: list_column(columns[name]) for name in VIA}
    return arrays | {"label": pd.array(columns["label"], "str")} | lists


def list_column(lists: Sequence[list[float] | None]) -> Any:
    """A column of lists of doubles; null where there is none."""
    import pandas as pd
    import pyarrow as pa

    return pd.arrays.ArrowExtensionArray(pa.array(lists, pa.large_list(pa.float64())))


def nulls(n: int) -> Any:
    """A `list_column` of n rows without lists, which takes no memory to speak of."""
    import pandas as pd
    import pyarrow as pa

    return pd.arrays.ArrowExtensionArray(pa.nulls(n, pa.large_list(pa.float64())))


def with_final_headings(frame: pd.DataFrame) -> bool:
    """Whether the rows of a checked frame of one kind have final headings."""
    return bool(frame["final_heading"].notna().any())


def row_name(frame: pd.DataFrame, row: int) -> str:
    """A row of a frame in messages, by its label."""
    label = frame.index[row]
    return f"row {short(label.item() if isinstance(label, np.generic) else label)}"


def scenarios(frame: pd.DataFrame) -> Iterator[Scenario]:
    """The rows of a checked frame, one `Scenario` each."""
    for row in frame[list(COLUMNS)].itertuples(index=False, name=None):
        yield scenario_of(dict(zip(COLUMNS, row, strict=True)))


def scenario_of(row: Mapping[Any, Any]) -> Scenario:
    """The scenario of a row that has the columns of `COLUMNS`, or some of them."""
    fields = {name: row[name] for name in NUMBERS if name in row}
    for name in ("label", "final_heading"):
        if not is_missing(row.get(name)):
            fields[name] = row[name]
    via: Any = row.get("via")
    if is_missing(via):
        xs, ys = (numbers_of(name, row.get(name)) or [] for name in VIA)
        if len(xs) != len(ys):
            counts = f"via_x has {len(xs)} numbers and via_y has {len(ys)}"
            raise ScenarioError(f"{counts}; expected as many")
        via = zip(xs, ys, strict=True)
    return Scenario(**fields, via=via, _radians=True)


def numbers_of(name: str, value: Any) -> list[float] | None:
    """A cell of `via_x` or `via_y`: a list of numbers, or a text of numbers and spaces.

    None for a cell without any. One number is a list of itself, since readers of CSV make numbers
    of such cells.
    """
    if is_missing(value):
        return None
    if isinstance(value, str):
        try:
            items: list[Any] = [number_of_text(text) for text in value.split()]
        except ValueError:
            expected = "expected numbers separated by spaces, such as 4 6"
            raise ScenarioError(f"{name} is {short(value)}; {expected}") from None
    elif isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim == 1):
        items = list(value)
    else:
        items = [value]
    return [checked_number(name, item) for item in items] or None


def is_missing(value: Any) -> bool:
    """Whether a cell is empty: None, NaN, or pandas' NA."""
    return (
        value is None
        or (isinstance(value, float) and math.isnan(value))
        or type(value).__name__ in ("NAType", "NaTType")
    )


def solve_command(row: Mapping[Any, Any]) -> str:
    """The `dubins-study solve` command of a row; numbers with all their digits, quoted for a shell.

    It states the profile and `time_limit_s` if the row has them.
    """
    s = scenario_of(row)
    words = ["dubins-study", "solve"]
    if s.start != (0.0, 0.0, 0.0):
        unit = "rad" if abs(s.heading) > LARGEST_BARE else ""  # which a bare number may not exceed
        words += ["--from", number_text(s.x), number_text(s.y), number_text(s.heading) + unit]
    for u, v in s.via:
        words += ["--via", number_text(u), number_text(v)]
    if s.final_heading is not None:
        words += ["--final-heading", f"{number_text(s.final_heading)}rad"]
    texts = {name: number_text(getattr(s, name)) for name in POSITIVE}
    texts |= {name: str(row[name]) for name in ("branch", "profile") if name in row}
    for name, text in texts.items():
        if text not in ("1", "best", "default"):
            words += [f"--{name}", text]
    if row.get("time_limit_s") is not None:
        words += ["--time-limit", number_text(row["time_limit_s"])]
    # without the dashes a negative number would be read as an option
    target = number_text(s.target_x), number_text(s.target_y)
    return shlex.join([*words, "--solver", str(row["solver"]), "--", *target])


def number_text(value: object) -> str:
    """A number that reads back as the same double; a whole one without its `.0`."""
    return repr(float(str(value))).removesuffix(".0")
