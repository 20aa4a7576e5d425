"""Pyomo models that are compiled once and asked many times, by engines and by Ipopt's executable.

Data are variables of the model. Engines get the NL file that Pyomo writes, read by casadi, with the
data as parameters; an executable on PATH gets a file for every question.
"""

from __future__ import annotations

import math
import os
import shutil
import tempfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.nlp_engines.program import EngineResult, Expressions, NlpCall, Program
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

VIAS = ("auto", "executable", "library")


class PyomoProgram(NamedTuple):
    """A Pyomo model with its n unknowns and its data in the caller's order.

    `rows` are the equations, with right-hand side 0, whose duals are wanted.
    """

    model: Any
    unknowns: list[Any]
    data: list[Any]
    rows: list[Any]


# (the initial guess (n,), the data, lower bounds (n,), upper bounds (n,), the seconds left)
Ask = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, float], EngineResult]


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


def asked(model: PyomoProgram, engine: NlpCall, native: bool) -> Ask:
    """A Pyomo model to be solved by an engine many times.

    A `native` engine gets the file as it is; for the others each inequality is an equation with a
    slack variable.
    """
    import casadi as ca
    from pyomo.repn.plugins.nl_writer import NLWriter

    with tempfile.TemporaryDirectory() as folder:
        name = FilePath(folder) / "model.nl"
        with name.open("w") as stream:
            # no presolve: every variable must keep its place, fixed or not
            info = NLWriter().write(model.model, stream, linear_presolve=False)
        file = ca.NlpBuilder()
        file.import_nl(str(name))
    given = [*model.unknowns, *model.data]
    places = {id(variable): place for place, variable in enumerate(given)}
    of_row = {id(row): place for place, row in enumerate(info.constraints)}
    rows = [of_row[id(row)] for row in model.rows]
    to_file = np.array([places[id(variable)] for variable in info.variables])
    n, lowest, highest = len(model.unknowns), np.array(file.g_lb), np.array(file.g_ub)
    # the file's order for an engine that gets the file, or else the caller's
    order = to_file[to_file < n] if native else np.arange(n)
    x, parameters = ca.SX.sym("x", n), ca.SX.sym("data", len(model.data))
    every = ca.SX(len(given), 1)
    every[[*order.tolist(), *range(n, len(given))]] = ca.vertcat(x, parameters)
    written = ca.Function("file", [ca.vertcat(*file.x)], [file.f, ca.vertcat(*file.g)])
    f, g = written(every[to_file.tolist()])
    sided = np.flatnonzero((lowest != highest) & (not native))
    sides = ca.Function("sides", [x, parameters], [g[sided.tolist()]])
    slack, bounds = ca.SX.sym("slack", sided.size), None
    if native:
        bounds = lowest, highest
    else:
        g -= np.where(lowest == highest, lowest, 0.0)
        g[sided.tolist()] -= slack
    expressions = Expressions(ca.vertcat(x, slack), parameters, f, g)

    def ask(
        guess: FloatArray, data: FloatArray, lower: FloatArray, upper: FloatArray, seconds: float
    ) -> EngineResult:
        begin, low, high = guess[order], lower[order], upper[order]
        if not native:
            begin = np.clip(begin, low, high)
            slacks = np.asarray(sides(begin, data)).ravel()
            begin = np.append(begin, np.clip(slacks, lowest[sided], highest[sided]))
            low, high = np.append(low, lowest[sided]), np.append(high, highest[sided])
        magnitude = 1.0 + float(np.abs(data).sum())
        program = Program(expressions, data, low, high, None, magnitude, bounds)
        result = engine(program, begin, seconds)
        point = np.empty(n)
        point[order] = result.x[:n]
        duals = None if result.duals is None else result.duals[rows]
        return result._replace(x=point, duals=duals)

    return ask


# Ipopt's application return statuses as Pyomo says them of the executable
_CLAIMS = {
    "optimal": Claim.LOCAL,
    "locallyOptimal": Claim.LOCAL,
    "infeasible": Claim.INFEASIBLE,
    "locallyInfeasible": Claim.INFEASIBLE,
    "maxIterations": Claim.LIMIT,
    "maxTimeLimit": Claim.LIMIT,
}


def executable(program: PyomoProgram, options: dict[str, Any]) -> Ask:
    """The `ipopt` executable on PATH, through Pyomo, which lets it run beyond its seconds."""
    from pyomo.environ import SolverFactory, Suffix

    model = program.model
    model.dual = Suffix(direction=Suffix.IMPORT)
    solver = SolverFactory("ipopt", options=options)

    def ask(
        guess: FloatArray, data: FloatArray, lower: FloatArray, upper: FloatArray, seconds: float
    ) -> EngineResult:
        for variable, value, *ends in zip(program.unknowns, guess, lower, upper, strict=True):
            low, high = (float(end) if math.isfinite(end) else None for end in ends)
            variable.setlb(low)
            variable.setub(high)
            variable.set_value(value, skip_validation=True)
            # the NL writer wants fixed variables marked as such, not only pinned by their bounds
            variable.fixed = low is not None and low == high
        for variable, value in zip(program.data, data, strict=True):
            variable.fix(value)
        results = solver.solve(model, load_solutions=False)
        status = str(results.solver.termination_condition)
        duals = None
        if len(results.solution):
            model.solutions.load_from(results)
            # ASL's duals have the opposite sign to Ipopt's own
            duals = np.array([-float(model.dual[row]) for row in program.rows])
        point = np.array([variable.value for variable in program.unknowns], dtype=np.float64)
        claim, message = _CLAIMS.get(status, Claim.FAILED), str(results.solver.message)
        return EngineResult(point, claim, duals, None, None, status, message)

    return ask
