"""Scenarios as a checked frame, one row each.

Columns may come in many forms.
"""

from __future__ import annotations

import math
import shlex
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from dubins_study.study.angle import LARGEST_BARE
from dubins_study.study.delimited import column_problems
from dubins_study.study.scenario import (
    COLUMNS,
    DEFAULTS,
    DEGREES,
    FREE,
    HEADINGS,
    LARGEST,
    LARGEST_EXTENT,
    LEAST,
    NUMBERS,
    POSITIVE,
    TOUR,
    VIA,
    Scenario,
    ScenarioError,
    checked_number,
)
from dubins_study.study.values import number_of_text, short
from dubins_study.study.words import Order

if TYPE_CHECKING:
    import pandas as pd

    from dubins_study.study.arrays import FloatArray


def scenario_column_problems(names: Sequence[Any]) -> list[str]:
    """Problems of a scenario table's column names.

    Each problem is a sentence. The target's columns are required, unless the table has a column of
    `TOUR`.
    """
    required = [name for name in COLUMNS if name not in DEFAULTS and not {*TOUR} & {*names}]
    return column_problems(names, required, [name for name in COLUMNS if name not in required])


def check_frame(frame: pd.DataFrame) -> pd.DataFrame:
    """Check a frame of scenarios and complete its columns.

    The result has the columns of `COLUMNS` in order, float64 where they are numbers; `order` is
    categorical. The caller's frame is not changed; its index is kept.

    Columns of `DEFAULTS` may be left out, and the target's where there is one of `TOUR`. A cell
    without a label, via points or a final heading may be empty. A start heading is free where it is
    `free`, or empty in a frame that has all columns; elsewhere an empty one is refused.

    Each value is read as `Scenario` takes it, and those of `VIA` as `numbers_of` does. A column
    `via` of lists of stops stands for those of `VIA`. A heading beyond a full turn that is no text
    gives a warning, as a scenario's does.

    Raises:
        ScenarioError: names the columns, or the first row that no scenario may have.
    """
    import pandas as pd

    if not isinstance(frame, pd.DataFrame):
        raise ScenarioError(f"expected a DataFrame of scenarios, got {type(frame).__name__}")
    names = list(frame.columns)
    if problems := scenario_column_problems([name for name in names if name != "via"]):
        raise ScenarioError(problems[0])
    if "via" in names and {*VIA} & {*names}:
        raise ScenarioError(f"via points are given twice; expected via, or {', '.join(VIA)}")
    columns = _columns_of_numbers(frame) or _columns_row_by_row(frame)
    for name in {*HEADINGS} & {*names}:
        beyond = np.abs(columns[name]) > LARGEST_BARE
        if beyond.any() and not all(isinstance(angle, str) for angle in frame[name][beyond]):
            warnings.warn(f"{name} {DEGREES}", stacklevel=5)  # at the call of `solve_frame`
    return pd.DataFrame({name: columns[name] for name in COLUMNS}, frame.index, copy=False)


def _columns_of_numbers(frame: pd.DataFrame) -> dict[str, Any] | None:
    """Columns of a frame of plain legs, by name.

    Each column is checked as a whole array. None if the rows have to be read one by one: if a row
    is no plain leg, holds a text for a number, or may be wrong.
    """
    n = len(frame)
    if not n or any(name in frame and frame[name].notna().any() for name in ("via", *VIA)):
        return None
    if any(name in frame and not (frame[name] == DEFAULTS[name]).all() for name in TOUR):
        return None
    columns: dict[str, Any] = {}
    for name in (*NUMBERS, "final_heading"):
        column = _doubles(frame, name)
        if column is None:
            return None
        columns[name] = column
    columns["label"] = ""
    if "label" in frame:
        columns["label"] = _labels(frame)
    if columns["label"] is None:
        return None
    # stricter than the rule for a row: the largest coordinates of all beside the smallest radius
    places = [columns[name] for name in ("x", "y", "target_x", "target_y")]
    worst = sum(max(abs(place.min()), abs(place.max())) for place in places)
    if worst > LARGEST_EXTENT * columns["radius"].min():
        return None
    columns |= dict.fromkeys(VIA, nulls(n))
    return columns | {"order": _orders(np.zeros(n, np.int8)), "closed": np.zeros(n, np.bool_)}


def _orders(codes: Any) -> Any:
    """Categorical column of orders.

    `codes` are places in `Order`: 0 given, 1 free. The column takes a byte a row.
    """
    import pandas as pd

    return pd.Categorical.from_codes(codes, pd.Index([str(order) for order in Order]))


def _doubles(frame: pd.DataFrame, name: str) -> FloatArray | None:
    """Column of numbers as read-only doubles.

    A column that the frame lacks holds its default. None if a value is missing, out of range, or a
    text.
    """
    if name not in frame:
        number = np.array(DEFAULTS.get(name), np.float64)  # None becomes NaN
        # a view of one number, which takes no memory
        return np.broadcast_to(number, len(frame))
    if frame[name].dtype.kind not in "iuf":
        return None
    with np.errstate(over="ignore"):
        values = frame[name].to_numpy(dtype=np.float64, na_value=np.nan).view()
    values.flags.writeable = False  # the frame's other readers share the array
    # min and max see NaN and both infinities without a temporary array of the frame's length
    low = values.min()
    high = values.max()
    if name == "final_heading":  # free where it is NaN
        low = np.fmin.reduce(values, initial=1.0)
        high = np.fmax.reduce(values, initial=1.0)
    if LEAST.get(name, -LARGEST) <= low and high <= LARGEST:  # neither holds for NaN
        return values
    return None


def _labels(frame: pd.DataFrame) -> pd.Series[Any] | None:
    """Column of labels.

    None if one is not a text that a row can hold.
    """
    from pandas.api.types import infer_dtype

    labels = frame["label"]
    if infer_dtype(labels, skipna=False) != "string" or labels.isna().any():
        return None
    storable = (text == text.encode("utf-8", "ignore").decode() for text in labels.unique())
    if not all(storable):
        return None
    return labels


def _columns_row_by_row(frame: pd.DataFrame) -> dict[str, Any]:
    """Columns of any frame, read row by row.

    Returns the columns by name. The first row that is no scenario raises a `ScenarioError` with the
    row's name.
    """
    import pandas as pd

    row_scenarios = []
    checked = {*COLUMNS} <= {*frame.columns}  # as `check_frame` returns it: NaN is free
    for row, values in enumerate(frame.itertuples(index=False, name=None)):
        fields = dict(zip(frame.columns, values, strict=True))
        try:
            heading = fields.get("heading", 0.0)
            if is_missing(heading) and not checked:
                raise ScenarioError(f"heading is {heading}; expected a number, or {FREE!r}")
            row_scenarios.append(scenario_of(fields))
        except ScenarioError as error:
            raise ScenarioError(f"{row_name(frame, row)}: {error}") from None
    columns = {name: [getattr(scenario, name) for scenario in row_scenarios] for name in COLUMNS}
    arrays: dict[str, Any] = {
        name: np.array(columns[name], np.float64) for name in (*NUMBERS, "final_heading")
    }
    lists = {name: list_column(columns[name]) for name in VIA}
    orders = _orders([[*Order].index(order) for order in columns["order"]])
    tours = {"order": orders, "closed": np.array(columns["closed"], np.bool_)}
    return arrays | {"label": pd.array(columns["label"], "str")} | lists | tours


def list_column(lists: Sequence[list[float] | None]) -> Any:
    """Column of lists of doubles.

    It is null where there is no list.
    """
    import pandas as pd
    import pyarrow as pa

    return pd.arrays.ArrowExtensionArray(pa.array(lists, pa.large_list(pa.float64())))


def nulls(n: int) -> Any:
    """A `list_column` of n rows without lists.

    It takes hardly any memory.
    """
    import pandas as pd
    import pyarrow as pa

    return pd.arrays.ArrowExtensionArray(pa.nulls(n, pa.large_list(pa.float64())))


def with_final_headings(frame: pd.DataFrame) -> bool:
    """Whether the rows have final headings.

    All rows of the checked frame are of one kind.
    """
    return bool(frame["final_heading"].notna().any())


def row_name(frame: pd.DataFrame, row: int) -> str:
    """Name of a frame's row, such as `row 7`.

    Messages use it. The number or text is the row's label in the frame's index.
    """
    label = frame.index[row]
    if isinstance(label, np.generic):
        label = label.item()
    return f"row {short(label)}"


def scenarios(frame: pd.DataFrame) -> Iterator[Scenario]:
    """Scenarios of a checked frame, one a row."""
    for row in frame[list(COLUMNS)].itertuples(index=False, name=None):
        yield scenario_of(dict(zip(COLUMNS, row, strict=True)))


def scenario_of(row: Mapping[Any, Any]) -> Scenario:
    """Scenario of a row.

    The row has the columns of `COLUMNS`, or some of them. A cell `via` stands for those of `VIA`.
    An empty start heading is free.
    """
    fields: dict[str, Any] = {name: row[name] for name in NUMBERS if name in row}
    for name in ("label", "final_heading", *TOUR):
        if not is_missing(row.get(name)):
            fields[name] = row[name]
    # an empty cell of these becomes None; `Scenario` refuses one of another number
    may_lack = ["heading"]
    if fields.get("closed") or fields.get("order", Order.GIVEN) != Order.GIVEN:
        may_lack += ["target_x", "target_y"]
    for name in may_lack:
        if is_missing(fields.get(name, 0.0)):
            fields[name] = None
    via: Any = row.get("via")
    if is_missing(via):
        xs, ys, headings = (numbers_of(name, row.get(name)) or [] for name in VIA)
        for name, others in (("via_y", ys), ("via_heading", headings or xs)):
            if len(xs) != len(others):
                counts = f"via_x has {len(xs)} numbers and {name} has {len(others)}"
                raise ScenarioError(f"{counts}; expected as many")
        via = [[x, y] for x, y in zip(xs, ys, strict=True)]
        for stop, heading in zip(via, headings, strict=False):  # `headings` may be empty
            if not math.isnan(heading):
                stop.append(heading)
    return Scenario(**fields, via=via, _radians=True)


def numbers_of(name: str, value: Any) -> list[float] | None:
    """Numbers of a cell of `VIA`.

    A cell is a list of numbers, or a text of numbers and spaces. None for an empty cell. One number
    counts as a list, since readers of CSV make numbers of such cells. In `via_heading` a number may
    be an angle with a unit, and a heading that is missing or `free` is NaN.
    """
    if is_missing(value):
        return None
    headings = name == "via_heading"
    if isinstance(value, str):
        try:
            items: list[Any] = value.split()
            if not headings:
                items = [number_of_text(text) for text in items]
        except ValueError:
            expected = "expected numbers separated by spaces, such as 4 6"
            raise ScenarioError(f"{name} is {short(value)}; {expected}") from None
    elif isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim == 1):
        items = list(value)
    else:
        items = [value]
    numbers = []
    for item in items:
        number = math.nan
        if not headings or not (is_missing(item) or item == FREE):
            number = checked_number(name, item)
        numbers.append(number)
    return numbers or None


def is_missing(value: Any) -> bool:
    """Whether a cell is None, NaN or NA."""
    return (
        value is None
        or (isinstance(value, float) and math.isnan(value))
        or type(value).__name__ in ("NAType", "NaTType")
    )


# options of `dubins-study solve` that need not be written where they have these values
_COMMAND_DEFAULTS = {"radius": "1", "speed": "1", "branch": "best", "profile": "default"}


def solve_command(row: Mapping[Any, Any]) -> str:
    """The `dubins-study solve` command of a row.

    Numbers have all their digits, and the command is quoted for a shell. It states the profile and
    `time_limit_s` if the row has them.
    """
    s = scenario_of(row)
    words = ["dubins-study", "solve"]
    if (s.x, s.y, s.heading) != (0.0, 0.0, 0.0):
        words += ["--from", number_text(s.x), number_text(s.y), _heading_text(s.heading)]
    for place, (u, v, *heading) in enumerate(s.via, 1):
        words += ["--via", number_text(u), number_text(v)]
        if heading:
            words += ["--via-heading", str(place), _heading_text(heading[0])]
    if s.order is not Order.GIVEN:
        words += ["--order", s.order]
    if s.closed:
        words += ["--closed"]
    if s.final_heading is not None:
        words += ["--final-heading", f"{number_text(s.final_heading)}rad"]
    texts = {name: number_text(getattr(s, name)) for name in POSITIVE}
    texts |= {name: str(row[name]) for name in ("branch", "profile") if name in row}
    for name, text in texts.items():
        if text != _COMMAND_DEFAULTS[name]:
            words += [f"--{name}", text]
    if row.get("time_limit_s") is not None:
        words += ["--time-limit", number_text(row["time_limit_s"])]
    words += ["--solver", str(row["solver"])]
    if s.target_x is not None:  # without the dashes a negative number would be read as an option
        words += ["--", number_text(s.target_x), number_text(s.target_y)]
    return shlex.join(words)


def _heading_text(heading: float | None) -> str:
    """Heading as the command line reads it.

    The command line takes no bare number beyond a full turn.
    """
    if heading is None:
        return FREE
    text = number_text(heading)
    if abs(heading) > LARGEST_BARE:
        text += "rad"
    return text


def number_text(value: object) -> str:
    """Text that reads back as the same double.

    A whole number has no `.0`.
    """
    return repr(float(str(value))).removesuffix(".0")
