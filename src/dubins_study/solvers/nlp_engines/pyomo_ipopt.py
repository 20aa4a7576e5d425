"""Ipopt on a Pyomo model that is compiled once and asked many times.

Data are variables that each question pins through their bounds, so one NL file serves all. An
executable on PATH solves it, or the Ipopt library inside the casadi wheel.
"""

from __future__ import annotations

import math
import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path as FilePath
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim


@dataclass
class Deadline:
    """When to stop (s, on `perf_counter`), set anew before every run.

    It must live as long as the programs that it stops: casadi does not keep what it calls.
    """

    at: float = math.inf
    watches: list[Any] = field(default_factory=list)

    def watch(self, variables: int, rows: int) -> Any:
        """The function that casadi calls after every iteration, at a cost of some 0.1 ms.

        Ipopt's own time limits are fixed once compiled.
        """
        import casadi

        deadline = self
        sizes = {"x": variables, "lam_x": variables, "g": rows, "lam_g": rows, "f": 1}

        class Watch(casadi.Callback):
            """Told of every iteration; answers whether to stop."""

            def __init__(self) -> None:
                casadi.Callback.__init__(self)
                self.construct("watch", {})

            def get_n_in(self) -> int:
                return int(casadi.nlpsol_n_out())

            def get_n_out(self) -> int:
                return 1

            def get_name_in(self, i: int) -> str:
                return str(casadi.nlpsol_out(i))

            def get_sparsity_in(self, i: int) -> Any:
                return casadi.Sparsity.dense(sizes.get(casadi.nlpsol_out(i), 0), 1)

            def eval(self, _: Any) -> list[int]:
                return [int(perf_counter() > deadline.at)]

        self.watches.append(Watch())
        return self.watches[-1]


class PyomoProgram(NamedTuple):
    """A Pyomo model with its variables (n of them) in the caller's order.

    `rows` are the equations, with right-hand side 0, whose duals are wanted.
    """

    model: Any
    variables: list[Any]
    rows: list[Any]


class NlFile(NamedTuple):
    """The contents of the file: casadi's MX symbols and expressions in the file's order."""

    x: Any
    f: Any
    g: Any
    lower: list[float]  # bounds of g
    upper: list[float]
    to_file: Any  # places of the caller's variables in the file's order, shape (n,)
    rows: list[int]  # places of the wanted rows in g


def nl_file(program: PyomoProgram) -> NlFile:
    """Write the model's NL file and read it."""
    import casadi
    from pyomo.repn.plugins.nl_writer import NLWriter

    with tempfile.TemporaryDirectory() as folder:
        file = FilePath(folder) / "model.nl"
        with file.open("w") as stream:
            # no presolve: every variable must keep its place, fixed or not
            info = NLWriter().write(program.model, stream, linear_presolve=False)
        builder = casadi.NlpBuilder()
        builder.import_nl(str(file))
    places = {id(variable): place for place, variable in enumerate(program.variables)}
    rows = {id(row): place for place, row in enumerate(info.constraints)}
    return NlFile(
        casadi.vertcat(*builder.x),
        builder.f,
        casadi.vertcat(*builder.g),
        builder.g_lb,
        builder.g_ub,
        np.array([places[id(variable)] for variable in info.variables]),
        [rows[id(row)] for row in program.rows],
    )


# What every engine of casadi is given: scalar expressions evaluate faster than matrix ones, and
# casadi would warn of every NaN that Ipopt tries on a word without a path.
PLAIN = {"print_time": False, "expand": True, "show_eval_warnings": False}

VIAS = ("auto", "executable", "library")

# Ipopt's application return statuses as the library names them, and as the executable says them
CLAIMS = {
    "Solve_Succeeded": Claim.LOCAL,
    "Solved_To_Acceptable_Level": Claim.LOCAL,
    "Feasible_Point_Found": Claim.FEASIBLE,
    "Infeasible_Problem_Detected": Claim.INFEASIBLE,
    "Maximum_Iterations_Exceeded": Claim.LIMIT,
    "Maximum_CpuTime_Exceeded": Claim.LIMIT,
    "Maximum_WallTime_Exceeded": Claim.LIMIT,
    "User_Requested_Stop": Claim.LIMIT,
    "optimal": Claim.LOCAL,
    "locallyOptimal": Claim.LOCAL,
    "infeasible": Claim.INFEASIBLE,
    "locallyInfeasible": Claim.INFEASIBLE,
    "maxIterations": Claim.LIMIT,
    "maxTimeLimit": Claim.LIMIT,
}

Options = tuple[tuple[str, Any], ...]


# (the initial guess, lower bounds, upper bounds), each of shape (n,) -> the result
Ask = Callable[[FloatArray, FloatArray, FloatArray], EngineResult]


def unavailable(via: str) -> str | None:
    """Why Ipopt cannot be reached this way, or None."""
    if missing := missing_package("pyomo"):
        return missing
    no_executable = None if on_path() else "no executable 'ipopt' on PATH"
    no_library = missing_package("casadi") and "the package casadi, which carries Ipopt, is missing"
    if via == "auto":
        return f"{no_executable}; {no_library}" if no_executable and no_library else None
    return no_executable if via == "executable" else no_library


def by_executable(via: str) -> bool:
    """Whether a model is solved by the executable: if asked for, or if PATH has one."""
    return via == "executable" or (via == "auto" and on_path())


def on_path() -> bool:
    """Whether PATH has an executable `ipopt`."""
    return _on_path(os.environ.get("PATH", ""))


@lru_cache(maxsize=4)
def _on_path(path: str) -> bool:
    # looked up once for every value of PATH: the search costs as much as a few iterations
    return shutil.which("ipopt", path=path) is not None


def compiled(
    program: PyomoProgram, options: Options, executable: bool, deadline: Deadline | None = None
) -> Ask:
    """A model to be solved by Ipopt again and again; only the library looks at the deadline."""
    return _executable(program, options) if executable else _library(program, options, deadline)


def _library(program: PyomoProgram, options: Options, deadline: Deadline | None) -> Ask:
    """Ipopt from the casadi wheel on the NL file that Pyomo writes."""
    import casadi

    file = nl_file(program)
    to_file = file.to_file
    from_file = np.argsort(to_file)
    watch = None if deadline is None else deadline.watch(file.x.numel(), file.g.numel())
    solver = casadi.nlpsol(
        "ipopt",
        "ipopt",
        {"x": file.x, "f": file.f, "g": file.g},
        {
            **PLAIN,
            "ipopt": dict(options),
            **({} if watch is None else {"iteration_callback": watch}),
        },
    )

    low, high, run = np.array(file.lower), np.array(file.upper), in_arrays(solver)

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> EngineResult:
        x, duals, stats = run(guess[to_file], (), lower[to_file], upper[to_file], low, high)
        status = str(stats["return_status"])
        return EngineResult(
            x[from_file],
            CLAIMS.get(status, Claim.FAILED),
            duals[file.rows],
            int(stats["iter_count"]),
            int(stats["n_call_nlp_f"]),
            status,
            status.replace("_", " ").lower(),
        )

    return ask


# (x0, p, lbx, ubx, lbg, ubg) -> the point, the duals of g, and casadi's statistics
ArrayCall = Callable[..., tuple[FloatArray, FloatArray, dict[str, Any]]]


def in_arrays(solver: Any) -> ArrayCall:
    """A solver of `casadi.nlpsol` that reads and writes arrays in place.

    Called with arrays, it takes 0.2 ms to convert them, as long as Ipopt's iteration.
    """
    buffer, evaluate = solver.buffer()
    given = [np.zeros(solver.numel_in(i)) for i in range(solver.n_in())]
    for i, array in enumerate(given):
        buffer.set_arg(i, memoryview(array.data))
    x, duals = np.zeros(solver.numel_out("x")), np.zeros(solver.numel_out("lam_g"))
    for array, name in ((x, "x"), (duals, "lam_g")):
        buffer.set_res(solver.index_out(name), memoryview(array.data))

    before = 0  # calls are counted over all runs

    def run(*values: Any) -> tuple[FloatArray, FloatArray, dict[str, Any]]:
        for array, value in zip(given, values, strict=False):  # without a guess of the duals
            array[:] = value
        nonlocal before
        evaluate()
        stats = buffer.stats()
        calls, before = stats["n_call_nlp_f"] - before, stats["n_call_nlp_f"]
        return x.copy(), duals.copy(), stats | {"n_call_nlp_f": calls}

    return run


def _executable(program: PyomoProgram, options: Options) -> Ask:
    """The `ipopt` executable on PATH, through Pyomo; the file is rewritten for every call."""
    from pyomo.environ import SolverFactory, Suffix

    model = program.model
    model.dual = Suffix(direction=Suffix.IMPORT)
    solver = SolverFactory("ipopt", options=dict(options))

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> EngineResult:
        for i, variable in enumerate(program.variables):
            variable.setlb(lower[i] if math.isfinite(lower[i]) else None)
            variable.setub(upper[i] if math.isfinite(upper[i]) else None)
            variable.set_value(guess[i], skip_validation=True)
            # the NL writer wants fixed variables marked as such, not only pinned by their bounds
            variable.fixed = bool(lower[i] == upper[i])
        results = solver.solve(model, load_solutions=False)
        status = str(results.solver.termination_condition)
        duals = None
        if len(results.solution):
            model.solutions.load_from(results)
            # ASL's duals have the opposite sign to Ipopt's own
            duals = np.array([-float(model.dual[row]) for row in program.rows])
        point = np.array([variable.value for variable in program.variables], dtype=np.float64)
        claim, message = CLAIMS.get(status, Claim.FAILED), str(results.solver.message)
        return EngineResult(point, claim, duals, None, None, status, message)

    return ask
