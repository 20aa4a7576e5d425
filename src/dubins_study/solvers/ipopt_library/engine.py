"""Ipopt on a Pyomo model that is compiled once and asked many times.

Data are variables that each question pins through their bounds, so one NL file serves all. An
`ipopt` executable on PATH solves it if there is one; otherwise the Ipopt library inside the casadi
wheel does, in process.
"""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.ipopt_library.deadline import Deadline
from dubins_study.solvers.ipopt_library.nl_file import Program, nl_file
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

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

Options = tuple[tuple[str, float], ...]


class Result(NamedTuple):
    """The result of one Ipopt run: the point (n,) and the duals (m,) of f + dual * row."""

    point: FloatArray
    duals: FloatArray | None
    status: str
    message: str
    iterations: int | None
    evaluations: int | None


# (the initial guess, lower bounds, upper bounds), each of shape (n,) -> the result
Ask = Callable[[FloatArray, FloatArray, FloatArray], Result]


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
    program: Program, options: Options, executable: bool, deadline: Deadline | None = None
) -> Ask:
    """A model to be solved by Ipopt again and again.

    Args:
        program: the model.
        options: Ipopt's own.
        executable: whether the executable on PATH solves it, or else casadi's library.
        deadline: when to stop, if ever; only the library looks at it, after every iteration.
    """
    return _executable(program, options) if executable else _library(program, options, deadline)


def _library(program: Program, options: Options, deadline: Deadline | None) -> Ask:
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
            "print_time": False,
            "expand": True,  # scalar expressions evaluate faster than the file's matrix ones
            "ipopt": {"print_level": 0, "sb": "yes", **dict(options)},
            **({} if watch is None else {"iteration_callback": watch}),
        },
    )

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> Result:
        x0, low, high = guess[to_file], lower[to_file], upper[to_file]
        solution = solver(x0=x0, lbx=low, ubx=high, lbg=file.lower, ubg=file.upper)
        stats = solver.stats()
        return Result(
            solution["x"].full().ravel()[from_file],
            solution["lam_g"].full().ravel()[file.rows],
            str(stats["return_status"]),
            str(stats["return_status"]).replace("_", " ").lower(),
            int(stats["iter_count"]),
            int(stats["n_call_nlp_f"]),
        )

    return ask


def _executable(program: Program, options: Options) -> Ask:
    """The `ipopt` executable on PATH, through Pyomo; the file is rewritten for every call."""
    from pyomo.environ import SolverFactory, Suffix

    model = program.model
    model.dual = Suffix(direction=Suffix.IMPORT)
    solver = SolverFactory("ipopt", options=dict(options))

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> Result:
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
        return Result(point, duals, status, str(results.solver.message), None, None)

    return ask
