"""The row: one judged attempt. Declared here once.

Whoever measures a share of a row fills a class of this module: the solver `Reported`, the check
`Judgement` and `Certificate`, the caller `Times`. From these classes follow the solution and the
answer, the encoding of a reply, its validation, the Arrow schema, the documentation, and which
columns the report reads. A new column is a field of one class, and a value where it is measured.
"""

# ruff: noqa: RUF009  `column` returns a field, which no instances share
from __future__ import annotations

from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import pyarrow as pa

    from dubins_study.study.path import Path
    from dubins_study.study.words import Claim, Proof, Verdict

VERSION = 6
# Keys of a part's Parquet metadata: the version of this schema, and the run that wrote the part.
VERSION_KEY = "dubins-study schema"
RUN_ID = "dubins-study run"


class Column(NamedTuple):
    """A column: name, Arrow type, unit and meaning. Missing and non-finite numbers are null.

    Args:
        detail: comparisons of solvers do not read it.
        manifest: the report shows it from the manifest, and does not read it.
        plotted: the plot of single attempts shows it.
    """

    name: str
    type: str
    unit: str
    meaning: str
    detail: bool = False
    manifest: bool = False
    plotted: bool = False


def column(unit: str, meaning: str, default: Any = None, **flags: bool) -> Any:
    """A field of a share that is a column of the row; a field without it is none."""
    return field(default=default, metadata={"unit": unit, "meaning": meaning} | flags)


# the Arrow type of an attribute, by its annotation
_TYPES = {
    **dict.fromkeys(("str", "str | None", "Claim", "Verdict", "Proof"), "string"),
    **dict.fromkeys(("float", "float | None"), "float64"),
    **{"int | None": "int64", "bool": "bool", "list[float] | None": "list<float64>"},
}


def columns(share: Any) -> tuple[Column, ...]:
    """The columns that a share declares."""
    declared = (each for each in fields(share) if each.metadata)
    return tuple(Column(each.name, _TYPES[str(each.type)], **each.metadata) for each in declared)


def names(columns: tuple[Column, ...]) -> list[str]:
    """The names of columns."""
    return [column.name for column in columns]


class Effort(NamedTuple):
    """What a solver spent on a subproblem: runs of the engine, their evaluations, their seconds."""

    subproblem: str
    runs: int
    evaluations: int | None
    seconds: float


@dataclass(frozen=True)
class Reported:
    """What a solver says; `solvers.protocol.Solution` has the meaning of every field.

    The path, the multipliers and the efforts are stored in columns of other shares.
    """

    claim: Claim = column("", "what the solver says", MISSING, plotted=True)
    path: Path | None = None
    claimed_length: float | None = column("length", "length that the solver reports")
    lower_bound: float | None = column("length", "bound that the solver reports")
    multipliers: tuple[float, float] | None = None
    iterations: int | None = column("", "the solver's own count", detail=True)
    evaluations: int | None = column(
        "", "the solver's own count of function evaluations", plotted=True
    )
    native_status: str = column("", "the backend's own status", "", detail=True, plotted=True)
    message: str = column(
        "", "the backend's own message, or the error", "", detail=True, plotted=True
    )
    presolved: bool = column(
        "", "the presolve answered, and no engine was asked", False, plotted=True
    )
    efforts: tuple[Effort, ...] = ()
    best_run: Effort | None = None


@dataclass(frozen=True, kw_only=True)
class Spent:
    """What the multipliers and efforts of a solution are stored as."""

    multiplier_x: float | None = column(
        "1", "dual of the end point's x equation, if any", detail=True
    )
    multiplier_y: float | None = column(
        "1", "dual of the end point's y equation, if any", detail=True
    )
    subproblems: str | None = column("", "what was solved in turn, e.g. LS RS LR RL")
    subproblem_runs: list[float] | None = column("", "runs of the engine, by subproblem")
    subproblem_evaluations: list[float] | None = column("", "evaluations, by subproblem")
    subproblem_s: list[float] | None = column("s", "time in the engine, by subproblem")
    best_run_evaluations: int | None = column("", "evaluations of the run that gave the answer")
    best_run_s: float | None = column("s", "time of that run: the engine called once")


@dataclass(frozen=True)
class Times:
    """Seconds on `perf_counter` in the process that solves; None for what was not reached."""

    build_s: float | None = column("s", "time to build the model")
    solve_s: float | None = column("s", "time to solve it", plotted=True)
    wall_s: float | None = column("s", "time of the whole attempt, judging left out", plotted=True)


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """The verdict on an answer and its evidence. Lengths in the scenario's unit; None if absent.

    `gap` only stands for a path that arrives. `wrong_basin` is a longer path that turns by another
    angle than the shortest one (more than 1 rad apart), or is of another word and more than 5 %
    longer: another local optimum, not a coarse answer.
    """

    region: str = column("", "outside, left disc, right disc or circle", MISSING, plotted=True)
    margin: float = column(
        "radius", "distance from the target to the nearer turning circle", MISSING, plotted=True
    )
    word: str | None = column("", "letters of the returned path", plotted=True)
    reference_word: str | None = column("", "letters of the shortest path of the branch")
    verdict: Verdict = column("", "what the check finds", MISSING, plotted=True)
    false_claim: bool = column("", "the claim is stronger than the verdict", MISSING, plotted=True)
    wrong_basin: bool = column(
        "", "longer, and turns by another angle or is of another word", False, plotted=True
    )
    length: float | None = column("length", "length of the path, from its controls", plotted=True)
    travel_time: float | None = column("time", "length / speed", detail=True)
    reference: float | None = column("length", "length compared with; near a circle, relaxed")
    gap: float | None = column(
        "1", "(length - reference) / max(reference, radius), if it arrives", plotted=True
    )
    miss: float | None = column(
        "length", "distance from the path's end to the target", plotted=True
    )
    curvature_excess: float | None = column(
        "1/radius", "curvature beyond what the branch allows", detail=True, plotted=True
    )


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """The proof of an answer and its evidence. Lengths in the scenario's unit; None where absent.

    Both bounds are None where the branch provably has no path. `study.check.extremal` measures the
    costates (nu1, nu2), Pontryagin's conditions and the cut margin.
    """

    proof: Proof = column("", "how far the proof goes: proved, bounded, extremal or none", MISSING)
    reference_low: float | None = column("length", "proven bounds of the shortest length")
    reference_high: float | None = column("length", "both null where provably no path exists")
    costate_x: float | None = column(
        "1", "nu1 of the path, with nu0 = 1 unless abnormal", detail=True
    )
    costate_y: float | None = column("1", "nu2 of the path", detail=True)
    abnormal: bool = column("", "nu0 = 0: the costates are of norm 1", False, detail=True)
    hamiltonian: float | None = column("1", "largest absolute H on the path", detail=True)
    sign_margin: float | None = column(
        "1", "least -u nu3 over turns; below 0, no extremal", detail=True
    )
    transversality: float | None = column("1", "absolute nu3 at the end", detail=True)
    pmp_residual: float | None = column(
        "1", "worst violation of Pontryagin's conditions", detail=True
    )
    cut_margin: float | None = column(
        "rad", "above 0, the path is shortest to its own end", detail=True
    )
    costate_error: float | None = column(
        "1", "distance of the multipliers from -(nu1, nu2) / nu0", detail=True
    )
    false_bound: bool = column("", "the solver's bound lies above `reference_high`", False)


KEY = (
    Column("scenario_id", "string", "", "hash of the scenario's numbers and label", plotted=True),
    Column(
        "solver", "string", "", "solver and its settings, e.g. turn-rate-qp[n=50]", plotted=True
    ),
    Column(
        "profile",
        "string",
        "",
        "named settings and tolerances: default, fast, accurate",
        plotted=True,
    ),
    Column("branch", "string", "", "best, LS, RS, LR or RL", plotted=True),
    Column(
        "initial_guess",
        "string",
        "",
        "cold, warm from the sweep's neighbour, or z1 z2 z3",
        plotted=True,
    ),
    Column("repeat", "int64", "", "0, 1, ... of the same cell"),
    Column(
        "code_digest",
        "string",
        "",
        "of the solver's code, settings, libraries: 12 hex digits",
        detail=True,
    ),
)
# The values of the key columns.
Key = tuple[str, str, str, str, str, int, str]
# The columns that name a cell, whatever code answers it.
CELL = KEY[:-1]

SCENARIO = (
    Column("x", "float64", "length", "start position"),
    Column("y", "float64", "length", "start position"),
    Column("heading", "float64", "rad", "start heading, counter-clockwise from +x"),
    Column("target_x", "float64", "length", "target position"),
    Column("target_y", "float64", "length", "target position"),
    Column("radius", "float64", "length", "minimum turning radius"),
    Column("speed", "float64", "length/time", "constant speed"),
    Column("label", "string", "", "name given to the scenario", plotted=True),
)
METHOD = (
    Column(
        "formulation",
        "string",
        "",
        "the problem that is handed over, e.g. joint NLP, LRS",
        plotted=True,
    ),
    Column("engine", "string", "", "the library that solves it, e.g. Ipopt", plotted=True),
    Column(
        "guess",
        "string",
        "",
        "where the search begins: bearing, zero, random, warm or none",
        plotted=True,
    ),
    Column(
        "tolerance", "float64", "", "feasibility that the engine is asked for, in its own terms"
    ),
)
OUTCOME = (Column("outcome", "string", "", "what happened to the process", plotted=True),)
CONTROLS = (
    Column("curvatures", "list<float64>", "1/length", "the path's controls, positive to the left"),
    Column("lengths", "list<float64>", "length", "how long each is held"),
)
ANSWER = (
    *(METHOD + columns(Judgement) + OUTCOME + columns(Reported)),
    *(columns(Certificate) + CONTROLS + columns(Times) + columns(Spent)),
)
RUN = (
    Column("versions", "string", "", "of the solver's libraries and ours, as JSON", manifest=True),
    Column("machine", "string", "", "machine kind: system, processor, cores", manifest=True),
    Column("threads", "int64", "", "threads the numerical libraries may use", detail=True),
    Column("jobs", "int64", "", "processes that solved side by side", detail=True),
    Column("executor", "string", "", "local or dask: what ran the cells", detail=True),
    Column("run_id", "string", "", "which run wrote the row", manifest=True),
    Column("started", "string", "UTC", "when the attempt started, ISO 8601", detail=True),
)
ROW = KEY + SCENARIO + ANSWER + RUN
# Columns that no solver fills, which are kept of an answer that does not fit.
NOT_SOLVERS = (
    *names(KEY + SCENARIO + METHOD + columns(Times) + RUN),
    *("region", "margin", "reference_word", "reference"),
)


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
