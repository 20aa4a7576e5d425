"""Frames of scenarios, solved and judged row by row.

The result has one row for each scenario and the same index.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.asking.attempt import (
    Answer,
    QuestionError,
    attempt,
    check_branch,
    check_request,
)
from dubins_study.asking.reply import DEFAULT_LIMIT, exception_text
from dubins_study.solvers.protocol import FrameSolution, Method, Question
from dubins_study.solvers.registry import load, stated_method, unavailable
from dubins_study.study.judging.certify import certify
from dubins_study.study.kinds.kind import Kind
from dubins_study.study.kinds.table import KINDS, rows_of
from dubins_study.study.path import CLAIMS, Paths
from dubins_study.study.rows.schema import (
    ANSWER,
    SCENARIO,
    Certificate,
    Column,
    Times,
    columns,
    names,
)
from dubins_study.study.scenario import DEFAULTS
from dubins_study.study.scenario_frame import check_frame, list_column, nulls, row_name
from dubins_study.study.scenario_frame import scenarios as scenarios_of
from dubins_study.study.tolerances import Tolerances, tolerances
from dubins_study.study.values import nearest
from dubins_study.study.words import Claim, Outcome

if TYPE_CHECKING:
    from dubins_study.study.judging.verdict_frame import FrameJudgement

COLUMNS = [*names(SCENARIO), *names(ANSWER)]


def solve_frame(
    scenarios: pd.DataFrame,
    solver: str = "analytic",
    branch: str = "best",
    *,
    profile: str = "default",
    limit: float = DEFAULT_LIMIT,
    certified: bool = False,
) -> pd.DataFrame:
    """Solve and judge every scenario of a frame.

    This happens in the caller's process, without a worker. The arguments and the returned frame are
    those of `experiments.solve.solve_frame`.
    """
    check_request(branch, limit)
    allowed = tolerances(profile, limit)
    backend = load(solver, profile)
    frame, others = checked(scenarios)
    check_branches(frame, branch)
    solve_whole = backend.solve_frame
    if (
        backend.presolve is True
        or unavailable(backend) is not None
        or branch not in backend.branches
    ):
        solve_whole = None  # the solver is asked row by row
    parts: list[tuple[Any, pd.DataFrame]] = []
    for kind, places in _parts(frame):
        part = frame
        if len(places) < len(frame):
            part = frame.iloc[places]
        if solve_whole is not None and kind.need_of_rows in backend.takes:
            rows = _all_at_once(
                part, solve_whole, stated_method(backend), branch, allowed, certified
            )
        else:
            answers = (attempt(backend, q, limit, allowed, solver) for q in questions(part, branch))
            rows = row_by_row(part, answers)
        parts.append((places, rows))
    return with_others(_in_order(parts, frame), others)


def _all_at_once(
    frame: pd.DataFrame,
    solve_whole: Callable[[pd.DataFrame, str], FrameSolution],
    method: Method,
    branch: str,
    allowed: Tolerances,
    certified: bool,
) -> pd.DataFrame:
    """The judged rows of a frame answered at once.

    `solve_whole` is the solver's `solve_frame`. All rows of the frame are of one kind. The time of
    a row is the call's time over the number of rows.
    """
    from dubins_study.study.judging.verdict_frame import judge_frame

    # the solver gets a copy, so that it cannot change the questions
    outcome, solution, seconds = _run(solve_whole, frame.copy(deep=False), branch)
    judgement = judge_frame(frame, solution.paths, solution.claim, branch, allowed)
    arrays = _arrays(solution, judgement)
    if certified:
        arrays |= _certificates(frame, solution, judgement, branch, allowed)
    row_s = seconds / max(1, len(frame))
    of_all_rows = vars(Times(build_s=0.0, solve_s=row_s, wall_s=row_s)) | method.columns()
    of_all_rows |= {
        "outcome": outcome,
        "native_status": solution.native_status,
        "claim": solution.claim,
        "message": solution.message,
    }
    return _framed(frame, arrays, of_all_rows)


def _run(
    solve_whole: Callable[[pd.DataFrame, str], FrameSolution], frame: pd.DataFrame, branch: str
) -> tuple[Outcome, FrameSolution, float]:
    """The outcome, the answers and the seconds they took.

    A solver that raises, or returns no `FrameSolution` for all rows, has answered no row: the
    outcome is `raised`, and the message says why.
    """
    began = perf_counter()
    try:
        solution = solve_whole(frame, branch)
        if not isinstance(solution, FrameSolution):
            raise TypeError(f"solve_frame returned {type(solution).__name__}, no FrameSolution")
        if len(solution.paths) != len(frame):
            raise TypeError(f"there are {len(solution.paths)} paths for {len(frame)} scenarios")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a backend's exception is its result
        seconds = perf_counter() - began
        none = np.zeros((2, len(frame)))
        nothing = Paths(none, none, np.zeros(len(frame), np.bool_))
        message = exception_text(error)
        return Outcome.RAISED, FrameSolution(Claim.NONE, nothing, message=message), seconds
    return Outcome.RETURNED, solution, perf_counter() - began


def _arrays(solution: FrameSolution, judgement: FrameJudgement) -> dict[str, Any]:
    """The answers' columns that differ between rows, by name.

    Codes and flat buffers become columns without a copy.
    """
    from dubins_study.study.judging.verdict_frame import TEXTS

    columns: dict[str, Any] = judgement._asdict()
    for name, texts in TEXTS.items():
        columns[name] = _texts(columns[name], texts)
    if not isinstance(solution.claim, Claim):
        columns["claim"] = _texts(solution.claim, CLAIMS)
    if not isinstance(solution.message, str):
        columns["message"] = _typed(solution.message, "string")
    columns["claimed_length"] = solution.claimed_length
    columns["lower_bound"] = solution.lower_bound
    columns["curvatures"], columns["lengths"] = _controls(solution.paths)
    return columns


def _certificates(
    frame: pd.DataFrame,
    solution: FrameSolution,
    judgement: FrameJudgement,
    branch: str,
    allowed: Tolerances,
) -> dict[str, Any]:
    """The certificate's columns, by name.

    Each row is certified by itself.
    """
    bounds = solution.lower_bound
    rows = []
    for number, scenario in enumerate(scenarios_of(frame)):
        lower_bound = None
        if bounds is not None:
            lower_bound = float(bounds[number])
        certificate = certify(
            scenario,
            solution.paths.path(number, scenario),
            judgement.row(number),
            branch,
            lower_bound=lower_bound,
            tolerances=allowed,
        )
        rows.append(vars(certificate))
    return _columns(rows, columns(Certificate))


def _texts(codes: Any, texts: Iterable[str]) -> Any:
    """A categorical column: `texts[code]` for each code.

    The code 255 stands for a missing text.
    """
    signed = np.asarray(codes, np.uint8).view(np.int8)  # 255 becomes -1, missing to pandas
    categories = pd.Index([_storable(text) for text in texts])
    return pd.Categorical.from_codes(signed, categories, validate=False)


def _storable(value: Any) -> Any:
    """The value's text without surrogates, which no column holds.

    None stays a missing value.
    """
    if value is None:
        return None
    return str.encode(str(value), "utf-8", "replace").decode()


def _constant(value: Any, kind: str, n: int) -> Any:
    """A column of n times one value.

    `kind` is the column's Arrow type. None is a missing value; for `bool` it becomes False.
    """
    missing = value is None
    match kind:
        case "string":
            code = 0
            if missing:
                code = 255
            return _texts(np.full(n, code, np.uint8), [value or ""])
        case "float64":
            return np.full(n, value, np.float64)  # None is NaN
        case "int64":
            return pd.arrays.IntegerArray(np.full(n, value or 0), np.full(n, missing))
        case "bool":
            return np.full(n, bool(value))
    return nulls(n)


def _controls(paths: Paths) -> tuple[Any, Any]:
    """Curvatures and lengths as two columns of lists.

    A row's lists have an entry for each arc that has a length. A row without a path is null. The
    lists of a column are parts of one flat buffer, so that none is copied.
    """
    from dubins_study.study.closed_form.kernel import flatten
    from dubins_study.study.closed_form.kernel_compile import loop_input

    n = len(paths)
    offsets = np.empty(n + 1, np.int64)
    flat = np.empty((2, paths.lengths.size + 1))
    # fills both: the flat curvatures and lengths, and the place where each row begins in them
    flatten(loop_input(paths.curvatures), loop_input(paths.lengths), offsets, *flat)
    missing: Any = None
    if paths.returned is not None:
        missing = pa.array(~paths.returned)
    bounds: Any = pa.array(offsets)
    curvatures, lengths = (
        pa.LargeListArray.from_arrays(bounds, pa.array(values[: offsets[-1]]), mask=missing)
        for values in flat
    )
    return pd.arrays.ArrowExtensionArray(curvatures), pd.arrays.ArrowExtensionArray(lengths)


def checked(scenarios: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The checked scenarios, and the caller's other columns.

    Returns two frames with one index. Columns of an answer are in neither, so that rows of answers
    can be asked again.
    """
    if not isinstance(scenarios, pd.DataFrame):
        return check_frame(scenarios), pd.DataFrame()
    of_scenarios = {*names(SCENARIO), "via"}
    of_answers = {*names(ANSWER)}
    # A misspelt column must not be replaced by its default: a name that is near to that of a
    # missing column goes to the check, which refuses it.
    missing = [name for name in DEFAULTS if name not in scenarios]
    unknown = [name for name in scenarios if name not in of_scenarios | of_answers]
    misspelt = {name for name in unknown if nearest(name, missing)}
    is_read = scenarios.columns.isin(of_scenarios | misspelt)
    others = scenarios.loc[:, ~is_read & ~scenarios.columns.isin(of_answers)]
    frame = scenarios
    if not is_read.all():  # to choose columns copies them
        frame = scenarios.loc[:, is_read]
    return check_frame(frame), others


def with_others(rows: pd.DataFrame, others: pd.DataFrame) -> pd.DataFrame:
    """Rows of answers, then the caller's other columns."""
    if others.shape[1]:
        return pd.concat([rows, others], axis=1)
    return rows


def _parts(frame: pd.DataFrame) -> list[tuple[Kind, Any]]:
    """The kinds in a frame, with their rows' places.

    Returns pairs of a kind and an array of places, counted from 0. A frame without rows gives one
    pair: legs, without places.
    """
    parts = [(kind, np.flatnonzero(rows_of(frame, kind))) for kind in KINDS]
    return [(kind, places) for kind, places in parts if len(places)] or parts[:1]


def check_branches(frame: pd.DataFrame, branch: str) -> None:
    """Refuse a branch that a row cannot have.

    The frame has passed `check_frame`. The QuestionError names the first such row.
    """
    # all rows of a kind have the same branches, so its first row stands for them
    firsts = sorted(int(places[0]) for _, places in _parts(frame) if len(places))
    for place in firsts:
        try:
            check_branch(next(scenarios_of(frame.iloc[[place]])), branch)
        except QuestionError as error:
            raise QuestionError(f"{row_name(frame, place)}: {error}") from None


def questions(frame: pd.DataFrame, branch: str) -> Iterator[Question]:
    """The questions of a checked frame, row by row."""
    return (Question(scenario, branch) for scenario in scenarios_of(frame))


def row_by_row(frame: pd.DataFrame, answers: Iterable[Answer]) -> pd.DataFrame:
    """The frame of single answers.

    `frame` has the scenarios. The answers come in the order of its rows, one for each.
    """
    return _framed(frame, _columns([answer.row() for answer in answers], ANSWER), {})


def _columns(rows: list[dict[str, Any]], of: tuple[Column, ...]) -> dict[str, Any]:
    """The columns `of` some rows, by name."""
    return {c.name: _typed([row[c.name] for row in rows], c.type) for c in of}


def _typed(values: Sequence[Any], kind: str) -> Any:
    """A column of values of one Arrow type, `kind`.

    The column has the dtype that `_constant` gives this type.
    """
    match kind:
        case "string":
            texts = pd.array([_storable(value) for value in values], "str")
            return pd.Categorical(texts)  # the dtype of texts in `_texts`
        case "float64":
            return np.array(values, np.float64)  # None is NaN
        case "int64":
            return pd.array(values, dtype="Int64")
        case "bool":
            return np.array(values, np.bool_)
    return list_column(values)


def _framed(
    frame: pd.DataFrame, arrays: dict[str, Any], of_all_rows: Mapping[str, Any]
) -> pd.DataFrame:
    """The rows of a frame: scenarios, then answers.

    A column of answers comes from `arrays`, or else repeats its one value from `of_all_rows`. A
    column that is in neither has missing values.
    """
    all_columns = {name: frame[name] for name in names(SCENARIO)} | arrays
    # one array of nulls serves all columns of its type
    constant = cache(partial(_constant, n=len(frame)))
    for column in ANSWER:
        if all_columns.get(column.name) is None:
            all_columns[column.name] = constant(of_all_rows.get(column.name), column.type)
    in_order = {name: all_columns[name] for name in COLUMNS}
    return pd.DataFrame(in_order, index=frame.index, copy=False)


def _in_order(parts: list[tuple[Any, pd.DataFrame]], frame: pd.DataFrame) -> pd.DataFrame:
    """The rows of all parts in the frame's order.

    Each part comes with the places of its rows in the frame.
    """
    _, first = parts[0]
    if len(parts) == 1:
        return first
    joined = pd.concat([rows.set_axis(places) for places, rows in parts]).sort_index()
    # texts of several categories are no categories once they are joined
    texts = first.select_dtypes("category").columns
    return joined.astype(dict.fromkeys(texts, "category")).set_axis(frame.index)
