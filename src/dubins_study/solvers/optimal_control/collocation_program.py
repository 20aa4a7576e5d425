"""The transcription in Pyomo as a nonlinear program that every engine of `nlp_engines` reads.

Pyomo writes the model as an NL file, and casadi reads it. The data, variables that are fixed,
become parameters, and each inequality an equation with a slack variable.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np

from dubins_study.solvers.ipopt_library.deadline import Deadline
from dubins_study.solvers.ipopt_library.nl_file import Program as PyomoProgram
from dubins_study.solvers.ipopt_library.nl_file import nl_file
from dubins_study.solvers.nlp_engines.program import Engine, EngineResult, Expressions, Program
from dubins_study.study.path import FloatArray

# (the initial guess, lower bounds, upper bounds), each of all variables -> the result
Ask = Callable[[FloatArray, FloatArray, FloatArray], EngineResult]


def asked(model: PyomoProgram, data: slice, engine: Engine, deadline: Deadline) -> Ask:
    """A Pyomo model to be solved by an engine again and again.

    The result has the model's variables in the caller's order and the duals of the rows that are
    wanted.

    Args:
        model: its rows have the right-hand side 0.
        data: the places of the data among the variables; their bounds pin them.
        deadline: when to stop.
    """
    import casadi as ca

    file = nl_file(model)
    lowest, highest = np.array(file.lower), np.array(file.upper)
    sided = np.flatnonzero(lowest != highest)
    places = np.arange(len(model.variables))
    free = np.delete(places, data)
    x, parameters = ca.SX.sym("x", free.size), ca.SX.sym("data", places[data].size)
    slack = ca.SX.sym("slack", sided.size)
    every = ca.SX(places.size, 1)
    every[free.tolist()], every[places[data].tolist()] = x, parameters
    f, g = ca.Function("file", [file.x], [file.f, file.g])(every[file.to_file.tolist()])
    equations = g - np.where(lowest == highest, lowest, 0.0)
    equations[sided.tolist()] -= slack
    expressions = Expressions(ca.vertcat(x, slack), parameters, f, equations)
    rows = ca.Function("rows", [x, parameters], [g[sided.tolist()]])

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> EngineResult:
        begin = np.clip(guess[free], lower[free], upper[free])
        slacks = np.clip(
            np.asarray(rows(begin, guess[data])).ravel(), lowest[sided], highest[sided]
        )
        program = Program(
            expressions,
            guess[data],
            np.concatenate((lower[free], lowest[sided])),
            np.concatenate((upper[free], highest[sided])),
            magnitude=1.0 + float(np.abs(guess[data]).sum()),
        )
        seconds = deadline.at - perf_counter()
        result = engine(program, np.concatenate((begin, slacks)), seconds)
        point = guess.copy()
        point[free] = result.x[: free.size]
        duals = None if result.duals is None else result.duals[file.rows]
        return result._replace(x=point, duals=duals)

    return ask
