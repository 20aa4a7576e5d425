"""Declare the row: one judged attempt.

Each share of a row is a class of this module, filled by the code that measures it: the solver fills
`Reported`, the check `Judgement` and `Certificate`, the caller `Times`. From these classes follow
the solution and the answer, the encoding of a reply, its validation, the Arrow schema, the
documentation, and which columns the report reads. A new column is a field of one class, and a value
where it is measured.
"""

# ruff: noqa: RUF009  `column` returns a field, which no instances share
from __future__ import annotations

from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import pyarrow as pa

    from dubins_study.study.arrays import FloatArray
    from dubins_study.study.path import Path
    from dubins_study.study.words import Claim, Proof, Verdict

VERSION = 6
# Keys of a part's Parquet metadata: the version of this schema, and the run that wrote the part.
VERSION_KEY = "dubins-study schema"
RUN_ID = "dubins-study run"


class Column(NamedTuple):
    """A column: name, Arrow type, unit and meaning.

    Missing and non-finite numbers are null.
    """

    name: str
    meaning: str
    type: str = "string"
    unit: str = ""
    detail: bool = False  # comparisons of solvers do not read it
    manifest: bool = False  # the report shows it from the manifest, and does not read it
    plotted: bool = False  # the plot of single attempts shows it


def column(meaning: str, unit: str = "", *, default: Any = None, **flags: bool) -> Any:
    """Declare a field as a column of the row.

    A field that is declared without this function is no column.
    """
    return field(default=default, metadata={"unit": unit, "meaning": meaning} | flags)


# the Arrow type of an attribute, by its annotation
_TYPES = {
    **dict.fromkeys(("str", "str | None", "Claim", "Verdict", "Proof"), "string"),
    **dict.fromkeys(("float", "float | None"), "float64"),
    **{"int | None": "int64", "bool": "bool", "list[float] | None": "list<float64>"},
}


def columns(share: Any) -> tuple[Column, ...]:
    """Columns that a share declares."""
    declared = (each for each in fields(share) if each.metadata)
    return tuple(
        Column(each.name, type=_TYPES[str(each.type)], **each.metadata) for each in declared
    )


def names(columns: tuple[Column, ...]) -> list[str]:
    """Names of columns."""
    return [column.name for column in columns]


class Effort(NamedTuple):
    """Effort of a solver on a subproblem.

    It counts runs of the engine, their evaluations, and their seconds.
    """

    subproblem: str
    runs: int
    evaluations: int | None
    seconds: float


@dataclass(frozen=True)
class Reported:
    """The report of a solver.

    `solvers.protocol.Solution` has the meaning of every field. The path, the multipliers and the
    efforts are stored in columns of other shares. Of the point of a convex problem and the trace
    only the check's measurements are stored.
    """

    claim: Claim = column("what the solver says", default=MISSING, plotted=True)
    path: Path | None = None
    claimed_length: float | None = column("length that the solver reports", "length")
    lower_bound: float | None = column("bound that the solver reports", "length")
    multipliers: tuple[float, float] | None = None
    iterations: int | None = column("the solver's own count", detail=True)
    evaluations: int | None = column("the solver's own count of function evaluations", plotted=True)
    native_status: str = column("the backend's own status", default="", detail=True, plotted=True)
    message: str = column(
        "the backend's own message, or the error", default="", detail=True, plotted=True
    )
    violation_slope: float | None = column(
        "0: no small change of the unknowns lowers what the last point misses by", "1"
    )
    point: FloatArray | None = None
    presolved: bool = column(
        "the presolve answered, and no engine was asked", default=False, plotted=True
    )
    efforts: tuple[Effort, ...] = ()
    best_run: Effort | None = None
    trace: tuple[tuple[int, Path], ...] = ()


@dataclass(frozen=True, kw_only=True)
class Spent:
    """Stored form of a solution's multipliers and efforts."""

    multiplier_x: float | None = column(
        "dual of the end point's x equation, if any", "1", detail=True
    )
    multiplier_y: float | None = column(
        "dual of the end point's y equation, if any", "1", detail=True
    )
    subproblems: str | None = column("what was solved in turn, e.g. LS RS LR RL")
    subproblem_runs: list[float] | None = column("runs of the engine, by subproblem")
    subproblem_evaluations: list[float] | None = column("evaluations, by subproblem")
    subproblem_s: list[float] | None = column("time in the engine, by subproblem", "s")
    best_run_evaluations: int | None = column("evaluations of the run that gave the answer")
    best_run_s: float | None = column("time of that run: the engine called once", "s")


@dataclass(frozen=True)
class Times:
    """Seconds on `perf_counter` in the solving process.

    None for a step that was not reached.
    """

    build_s: float | None = column("time to build the model", "s")
    solve_s: float | None = column("time to solve it", "s", plotted=True)
    wall_s: float | None = column("time of the whole attempt, judging left out", "s", plotted=True)


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """Verdict on an answer, and its evidence.

    Lengths are in the scenario's unit; None if absent.

    For a frozen convex problem `length` is the objective at the feasible point made from the
    answer, and `miss` the largest violation of a constraint. `gap` exists only for a path that
    arrives.

    `wrong_basin` marks another local optimum, not a coarse answer. Such a path is longer, and turns
    by another angle than the shortest one (more than 1 rad apart), or is of another word and more
    than 5 % longer.
    """

    region: str | None = column(
        "outside, left disc, right disc or circle, of one leg with a free final heading",
        plotted=True,
    )
    margin: float | None = column(
        "distance from the target to the nearer turning circle, of such a leg",
        "radius",
        plotted=True,
    )
    word: str | None = column("letters of the returned path", plotted=True)
    reference_word: str | None = column("letters of the shortest path of the branch")
    verdict: Verdict = column("what the check finds", default=MISSING, plotted=True)
    false_claim: bool = column(
        "the claim is stronger than the verdict", default=MISSING, plotted=True
    )
    wrong_basin: bool = column(
        "longer, and turns by another angle or is of another word", default=False, plotted=True
    )
    length: float | None = column("length of the path, from its controls", "length", plotted=True)
    travel_time: float | None = column("length / speed", "time", detail=True)
    reference: float | None = column(
        "length compared with; of a route the proven lower bound", "length"
    )
    gap: float | None = column(
        "(length - reference) / max(reference, radius), if it arrives", "1", plotted=True
    )
    miss: float | None = column(
        "largest distance by which the target or a via point is missed", "length", plotted=True
    )
    visits: list[float] | None = column(
        "where along the path it passes its via points, an arc length each", "length"
    )
    visit_order: list[float] | None = column(
        "of a tour: the via points in the order in which it passes them, the first is 0", "1"
    )
    start_heading: float | None = column("the path's own, where the scenario's is free", "rad")
    curvature_excess: float | None = column(
        "curvature beyond what the branch allows", "1/radius", detail=True, plotted=True
    )
    trace_evaluations: list[float] | None = column("evaluations after which a solver was better")
    trace_lengths: list[float] | None = column(
        "length of its best path then that arrives, by the check", "length"
    )
    dual_residual: float | None = column("of a convex problem: violated stationarity", "1")
    duality_gap: float | None = column("of a convex problem: its two objectives, apart", "1")
    certified_gap: float | None = column(
        "of a convex problem: relative width of the interval that the answer itself proves", "1"
    )


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Proof of an answer, and its evidence.

    Lengths are in the scenario's unit; None where absent. Both bounds are None where the branch
    provably has no path. `study.check.extremal` measures the costates (nu1, nu2), Pontryagin's
    conditions and the cut margin.
    """

    proof: Proof = column(
        "how far the proof goes: proved, bounded, extremal or none", default=MISSING
    )
    reference_low: float | None = column("proven bounds of the shortest length", "length")
    reference_high: float | None = column("both null where provably no path exists", "length")
    costate_x: float | None = column(
        "nu1 at the path's end, with nu0 = 1 unless abnormal", "1", detail=True
    )
    costate_y: float | None = column("nu2 at the path's end", "1", detail=True)
    abnormal: bool = column("nu0 = 0: the costates are of norm 1", default=False, detail=True)
    hamiltonian: float | None = column("largest absolute H on the path", "1", detail=True)
    sign_margin: float | None = column(
        "least -u nu3 over turns; below 0, no extremal", "1", detail=True
    )
    transversality: float | None = column("absolute nu3 at a free end", "1", detail=True)
    pmp_residual: float | None = column(
        "worst violation of Pontryagin's conditions", "1", detail=True
    )
    cut_margin: float | None = column(
        "above 0, the path is shortest to its own end", "rad", detail=True
    )
    costate_error: float | None = column(
        "distance of the multipliers from -(nu1, nu2) / nu0", "1", detail=True
    )
    false_bound: bool = column("the solver's bound lies above `reference_high`", default=False)


KEY = (
    Column("scenario_id", "hash of the scenario's numbers and label", plotted=True),
    Column("solver", "solver and its settings, e.g. turn-rate-qp[n=50]", plotted=True),
    Column("profile", "named settings and tolerances: default, fast, accurate", plotted=True),
    Column("branch", "best, or the word that is asked for", plotted=True),
    Column("initial_guess", "cold, warm from the sweep's neighbour, or z1 z2 z3", plotted=True),
    Column("repeat", "0, 1, ... of the same cell", "int64"),
    Column("code_digest", "of the solver's code, settings, libraries: 12 hex digits", detail=True),
)
# The values of the key columns.
Key = tuple[str, str, str, str, str, int, str]
# The columns that name a cell, whatever code answers it.
CELL = KEY[:-1]

SCENARIO = (
    Column("x", "start position", "float64", "length"),
    Column("y", "start position", "float64", "length"),
    Column("heading", "start heading, counter-clockwise from +x; null: free", "float64", "rad"),
    Column("target_x", "target position; null: none, or closed", "float64", "length"),
    Column("target_y", "target position; null: none, or closed", "float64", "length"),
    Column("radius", "minimum turning radius", "float64", "length"),
    Column("speed", "constant speed", "float64", "length/time"),
    Column("label", "name given to the scenario", plotted=True),
    Column("via_x", "points to pass on the way; null: none", "list<float64>", "length"),
    Column("via_y", "as many; null: none", "list<float64>", "length"),
    Column("via_heading", "headings at them; null: free", "list<float64>", "rad"),
    Column("final_heading", "heading at the target; null: free", "float64", "rad"),
    Column("order", "of the via points: given or free; null: given"),
    Column("closed", "whether it ends as it starts; null: no", "bool"),
)
METHOD = (
    Column("formulation", "the problem that is handed over, e.g. joint NLP, LRS", plotted=True),
    Column("engine", "the library that solves it, e.g. Ipopt", plotted=True),
    Column("guess", "where the search begins, e.g. bearing, straight, warm or none", plotted=True),
    Column(
        "guesses",
        "one, words (one a word), several (a word), blind, several blind, warm or none",
        plotted=True,
    ),
    Column("presolve", "whether the solver's questions are presolved", "bool"),
    Column("proves", "smallest relative gap that its settings let it prove", "float64", "1"),
    Column("knows", "of the answer beforehand: formula, words, shape, presolve", plotted=True),
    Column("tolerance", "feasibility that the engine is asked for, in its own terms", "float64"),
)
OUTCOME = (Column("outcome", "what happened to the process", plotted=True),)
CONTROLS = (
    Column("curvatures", "the path's controls, positive to the left", "list<float64>", "1/length"),
    Column("lengths", "how long each is held", "list<float64>", "length"),
)
ANSWER = (
    *(METHOD + columns(Judgement) + OUTCOME + columns(Reported)),
    *(columns(Certificate) + CONTROLS + columns(Times) + columns(Spent)),
)
_SECONDS = ("float64", "s")
RUN = (
    Column("versions", "of the solver's libraries and ours, as JSON", manifest=True),
    Column("machine", "machine kind: system, processor, cores", detail=True),
    Column("threads", "threads the numerical libraries may use", "int64", detail=True),
    Column("jobs", "processes that solved side by side", "int64", detail=True),
    Column("limit_s", "time limit; null in older rows: the manifest's", *_SECONDS, plotted=True),
    Column("floor_s", "of the engine, called once on a trivial problem", "float64", "s"),
    Column("memory_mib", "most that the solve added to its process' memory", "float64", "MiB"),
    Column("executor", "local or dask: what ran the cells; file: answers of a file", detail=True),
    Column("run_id", "which run wrote the row", manifest=True),
    Column("started", "when the attempt started, ISO 8601", "string", "UTC", detail=True),
)
ROW = KEY + SCENARIO + ANSWER + RUN
# columns of times that an attempt took on its machine
MEASURED_TIMES = tuple(each.name for each in ROW if each.unit == "s" and each.name != "limit_s")


def arrow_schema() -> pa.Schema:
    """The row as Arrow and Parquet hold it."""
    import pyarrow as pa

    types = {
        "string": pa.string(),
        "float64": pa.float64(),
        "int64": pa.int64(),
        "bool": pa.bool_(),
        "list<float64>": pa.list_(pa.float64()),
    }
    return pa.schema([pa.field(column.name, types[column.type]) for column in ROW])
