"""Pyomo models, compiled once and solved many times.

Data are variables of the model. Pyomo writes the model as an NL file, which casadi reads with the
data as parameters.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.nlp_engines.program import Expressions, NlpCall, Program
from dubins_study.solvers.runs import EngineResult
from dubins_study.study.arrays import FloatArray


class PyomoProgram(NamedTuple):
    """A Pyomo model, its unknowns and its data.

    The n unknowns and the data are in the caller's order. `rows` are equations with right-hand side
    0 whose duals are wanted.
    """

    model: Any
    unknowns: list[Any]
    data: list[Any]
    rows: list[Any]


# (the initial guess (n,), the data, lower bounds (n,), upper bounds (n,), the seconds left)
Ask = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, float], EngineResult]


def asked(model: PyomoProgram, engine: NlpCall, native: bool) -> Ask:
    """A function that solves a Pyomo model many times.

    A `native` engine gets the file as it is. For the others each inequality becomes an equation
    with a slack variable. Points are in the order of `model.unknowns`, duals in that of
    `model.rows`.
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
    variables = [*model.unknowns, *model.data]
    places = {id(variable): place for place, variable in enumerate(variables)}
    of_row = {id(row): place for place, row in enumerate(info.constraints)}
    rows = [of_row[id(row)] for row in model.rows]
    # for each variable of the file, its place in the caller's order
    to_file = np.array([places[id(variable)] for variable in info.variables])
    n = len(model.unknowns)
    lowest = np.array(file.g_lb)
    highest = np.array(file.g_ub)
    # the file's order for an engine that gets the file, or else the caller's
    order: Any = np.arange(n)
    if native:
        order = to_file[to_file < n]
    x = ca.SX.sym("x", n)
    parameters = ca.SX.sym("data", len(model.data))
    symbols = ca.SX(len(variables), 1)
    symbols[[*order.tolist(), *range(n, len(variables))]] = ca.vertcat(x, parameters)
    file_functions = ca.Function("file", [ca.vertcat(*file.x)], [file.f, ca.vertcat(*file.g)])
    f, g = file_functions(symbols[to_file.tolist()])
    inequalities = np.flatnonzero(lowest != highest)
    if native:  # no row becomes an equation
        inequalities = inequalities[:0]
    inequality_values = ca.Function("sides", [x, parameters], [g[inequalities.tolist()]])
    slack = ca.SX.sym("slack", inequalities.size)
    bounds = None
    if native:
        bounds = lowest, highest
    else:
        g -= np.where(lowest == highest, lowest, 0.0)
        g[inequalities.tolist()] -= slack
    expressions = Expressions(ca.vertcat(x, slack), p=parameters, f=f, g=g)

    def ask(
        guess: FloatArray, data: FloatArray, lower: FloatArray, upper: FloatArray, seconds: float
    ) -> EngineResult:
        begin = guess[order]
        low = lower[order]
        high = upper[order]
        if not native:
            # slacks begin at the values of their rows, within the rows' ends
            begin = np.clip(begin, low, high)
            slacks = np.asarray(inequality_values(begin, data)).ravel()
            begin = np.append(begin, np.clip(slacks, lowest[inequalities], highest[inequalities]))
            low = np.append(low, lowest[inequalities])
            high = np.append(high, highest[inequalities])
        magnitude = 1.0 + float(np.abs(data).sum())
        program = Program(
            expressions, p=data, lower=low, upper=high, magnitude=magnitude, bounds=bounds
        )
        result = engine(program, begin, seconds)
        point = np.empty(n)
        point[order] = result.x[:n]
        duals = result.duals
        if duals is not None:
            duals = duals[rows]
        return result._replace(x=point, duals=duals)

    return ask
