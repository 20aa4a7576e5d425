"""The row: one judged attempt. Declared here once; its documentation is generated from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import pyarrow as pa

VERSION = 6
# Keys of a part's Parquet metadata: the version of this schema, the run that wrote the part, and,
# of a streamed part, its chunk as JSON (`study.rows.chunk.Chunk`).
VERSION_KEY = "dubins-study schema"
RUN_ID = "dubins-study run"
CHUNK = "dubins-study chunk"


class Column(NamedTuple):
    """A column: name, Arrow type, unit and meaning. Missing and non-finite numbers are null."""

    name: str
    type: str
    unit: str
    meaning: str


KEY = (
    Column("scenario_id", "string", "", "hash of the scenario's numbers and label"),
    Column("solver", "string", "", "solver and its settings, e.g. turn-rate-qp[n=50]"),
    Column("profile", "string", "", "named settings and tolerances: default, fast, accurate"),
    Column("branch", "string", "", "best, LS, RS, LR or RL"),
    Column("initial_guess", "string", "", "cold, warm from the sweep's neighbour, or z1 z2 z3"),
    Column("repeat", "int64", "", "0, 1, ... of the same cell"),
    Column("code_digest", "string", "", "of the solver's code, settings, libraries: 12 hex digits"),
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
    Column("label", "string", "", "name given to the scenario"),
)
ANSWER = (
    Column("formulation", "string", "", "the problem that is handed over, e.g. joint NLP, LRS"),
    Column("engine", "string", "", "the library that solves it, e.g. Ipopt"),
    Column("guess", "string", "", "where the search begins: bearing, zero, random, warm or none"),
    Column(
        "tolerance", "float64", "", "feasibility that the engine is asked for, in its own terms"
    ),
    Column("region", "string", "", "outside, left disc, right disc or circle"),
    Column("margin", "float64", "radius", "distance from the target to the nearer turning circle"),
    Column("word", "string", "", "letters of the returned path"),
    Column("reference_word", "string", "", "letters of the shortest path of the branch"),
    Column("outcome", "string", "", "what happened to the process"),
    Column("claim", "string", "", "what the solver says"),
    Column("presolved", "bool", "", "the presolve answered, and no engine was asked"),
    Column("verdict", "string", "", "what the check finds"),
    Column("false_claim", "bool", "", "the claim is stronger than the verdict"),
    Column("wrong_basin", "bool", "", "longer, and turns by another angle or is of another word"),
    Column("native_status", "string", "", "the backend's own status"),
    Column("message", "string", "", "the backend's own message, or the error"),
    Column("length", "float64", "length", "length of the path, from its controls"),
    Column("travel_time", "float64", "time", "length / speed"),
    Column("reference", "float64", "length", "length compared with; near a circle, relaxed"),
    Column("gap", "float64", "1", "(length - reference) / max(reference, radius), if it arrives"),
    Column("miss", "float64", "length", "distance from the path's end to the target"),
    Column("curvature_excess", "float64", "1/radius", "curvature beyond what the branch allows"),
    Column("claimed_length", "float64", "length", "length that the solver reports"),
    Column("lower_bound", "float64", "length", "bound that the solver reports"),
    Column("multiplier_x", "float64", "1", "dual of the end point's x equation, if any"),
    Column("multiplier_y", "float64", "1", "dual of the end point's y equation, if any"),
    Column("proof", "string", "", "how far the proof goes: proved, bounded, extremal or none"),
    Column("reference_low", "float64", "length", "proven bounds of the shortest length"),
    Column("reference_high", "float64", "length", "both null where provably no path exists"),
    Column("costate_x", "float64", "1", "nu1 of the path, with nu0 = 1 unless abnormal"),
    Column("costate_y", "float64", "1", "nu2 of the path"),
    Column("abnormal", "bool", "", "nu0 = 0: the costates are of norm 1"),
    Column("hamiltonian", "float64", "1", "largest absolute H on the path"),
    Column("sign_margin", "float64", "1", "least -u nu3 over turns; below 0, no extremal"),
    Column("transversality", "float64", "1", "absolute nu3 at the end"),
    Column("pmp_residual", "float64", "1", "worst violation of Pontryagin's conditions"),
    Column("cut_margin", "float64", "rad", "above 0, the path is shortest to its own end"),
    Column("costate_error", "float64", "1", "distance of the multipliers from -(nu1, nu2) / nu0"),
    Column("false_bound", "bool", "", "the solver's bound lies above `reference_high`"),
    Column("curvatures", "list<float64>", "1/length", "the path's controls, positive to the left"),
    Column("lengths", "list<float64>", "length", "how long each is held"),
    Column("build_s", "float64", "s", "time to build the model"),
    Column("solve_s", "float64", "s", "time to solve it"),
    Column("wall_s", "float64", "s", "time of the whole attempt, judging left out"),
    Column("iterations", "int64", "", "the solver's own count"),
    Column("evaluations", "int64", "", "the solver's own count of function evaluations"),
    Column("subproblems", "string", "", "what was solved in turn, e.g. LS RS LR RL"),
    Column("subproblem_runs", "list<float64>", "", "runs of the engine, by subproblem"),
    Column("subproblem_evaluations", "list<float64>", "", "evaluations, by subproblem"),
    Column("subproblem_s", "list<float64>", "s", "time in the engine, by subproblem"),
    Column("best_run_evaluations", "int64", "", "evaluations of the run that gave the answer"),
    Column("best_run_s", "float64", "s", "time of that run: the engine called once"),
)
RUN = (
    Column("versions", "string", "", "of the solver's libraries and ours, as JSON"),
    Column("machine", "string", "", "machine kind: system, processor, cores"),
    Column("threads", "int64", "", "threads the numerical libraries may use"),
    Column("jobs", "int64", "", "processes that solved side by side"),
    Column("executor", "string", "", "local or dask: what ran the cells"),
    Column("run_id", "string", "", "which run wrote the row"),
    Column("started", "string", "UTC", "when the attempt started, ISO 8601"),
)
ROW = KEY + SCENARIO + ANSWER + RUN


def names(columns: tuple[Column, ...]) -> list[str]:
    """The names of columns."""
    return [column.name for column in columns]


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


def documentation() -> str:
    """The row's columns as a Markdown table."""
    lines = ["| column | type | unit | meaning |", "|---|---|---|---|"]
    lines += [f"| `{c.name}` | {c.type} | {c.unit or '–'} | {c.meaning} |" for c in ROW]
    return "\n".join(lines) + "\n"
