"""CONOPT, a generalised reduced gradient method, by GAMS's package `conopt`.

Its demo mode takes 1000 variables and equations. Its tolerances cannot be set: 1e-7 of each
equation and of the reduced gradient, both scaled.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.gams import status
from dubins_study.solvers.nlp_engines.program import EngineResult, Functions, NlpCall, Program
from dubins_study.study.path import FloatArray


def conopt(options: dict[str, Any]) -> NlpCall:
    """CONOPT 4 with first and second derivatives."""

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        import conopt

        model, messages = _model_data(program, guess), _classes()[1]()
        solver = conopt.Conopt("program")
        solver.setMessageHandler(messages)
        solver.loadModel(model)
        for name, value in options.items():
            getattr(solver, f"set{name}")(value)
        solver.setResLim(float(seconds))
        solver.solve()
        numbers = solver.solutionStatus(), solver.modelStatus()
        x, marginals = solver.getVariableValues(), solver.getConstraintMarginals()
        return EngineResult(
            np.array(x) if x else np.full(guess.size, math.nan),
            status(*numbers)[1],
            -np.array(marginals[:-1]) if marginals else None,
            int(solver.iterations()),
            model.points,
            "solver status {}, model status {}".format(*numbers),
            messages.last,
        )

    return run


def _model_data(program: Program, guess: FloatArray) -> Any:
    """The program as CONOPT takes it: the objective is the last of its rows."""
    import conopt

    model = _classes()[0](program.functions, guess)
    n, m = guess.size, model.m
    infinity = conopt.Conopt.Infinity
    bounds = zip(*np.clip((program.lower, program.upper), -infinity, infinity), strict=True)
    for (lower, upper), value in zip(bounds, guess, strict=True):
        model.addVariable(float(lower), float(upper), float(value))
    columns, nonlinear = list(range(n)), [1] * n
    for _ in range(m):
        model.addConstraint(conopt.ConstraintType_Eq, 0.0, columns, [0.0] * n, nonlinear)
    model.addConstraint(conopt.ConstraintType_Free, 0.0, columns, [0.0] * n, nonlinear)
    model.setObjectiveElement(conopt.ObjectiveElement_Constraint, m)
    model.setOptimizationSense(conopt.Sense_Minimize)
    rows, columns = (places.tolist() for places in np.triu_indices(n)[::-1])
    model.setSDEvaluationType(conopt.SDEvaluationType_Lagrangian)
    model.setSDLagrangianStructure(rows, columns)
    return model


@cache
def _classes() -> tuple[type, type]:
    """The callbacks, which CONOPT wants as classes that inherit from its own."""
    import conopt

    class ModelData(conopt.ModelData):  # type: ignore[misc]
        """Rows and derivatives of a program; each point is evaluated once for all rows."""

        def __init__(self, functions: Functions, guess: FloatArray) -> None:
            super().__init__()
            self.functions, self.points = functions, 0
            self.m = functions.equations(guess).size
            self.x = guess
            self.values: list[float] | None = None
            self.slopes: FloatArray | None = None

        def initFDEvaluation(  # noqa: N802
            self, x: Any, rowlist: Any, mode: int, numthread: int, ignerr: int
        ) -> None:
            self.x, self.values, self.slopes = np.array(x), None, None

        def evaluateNonlinearTerm(  # noqa: N802
            self, x: Any, rowno: int, ignerr: bool, thread: int
        ) -> float:
            if self.values is None:
                self.points += 1
                equations = self.functions.equations(self.x).tolist()
                self.values = [*equations, float(self.functions.objective(self.x))]
            return self.values[rowno]

        def evaluateNonlinearJacobian(  # noqa: N802
            self, x: Any, rowno: int, jacnum: Any, ignerr: bool, thread: int
        ) -> list[float]:
            if self.slopes is None:
                jacobian = self.functions.jacobian(self.x)
                self.slopes = np.vstack((jacobian, self.functions.gradient(self.x)))
            slopes: list[float] = self.slopes[rowno, list(jacnum)].tolist()
            return slopes

        def evaluateSDLagrangian(  # noqa: N802
            self, x: Any, u: Any, hessianrow: Any, hessiancol: Any
        ) -> list[float]:
            values = self._curvature(x, u)[list(hessianrow), list(hessiancol)]
            return values.tolist()  # type: ignore[no-any-return]

        def evaluateSDDirLagrangian(  # noqa: N802
            self, x: Any, dx: Any, u: Any, newpoint: bool
        ) -> list[float]:
            return (self._curvature(x, u) @ np.array(dx)).tolist()  # type: ignore[no-any-return]

        def _curvature(self, x: Any, u: Any) -> FloatArray:
            return self.functions.curvature(np.array(x), u[-1], np.array(u[:-1]))

    class Messages(conopt.MessageHandler):  # type: ignore[misc]
        """Keeps the last of CONOPT's statements, which begin with two stars; prints none."""

        last = ""

        def message(self, smsg: int, dmsg: int, nmsg: int, msgv: Any) -> int:
            statements = [line for line in msgv if line.startswith(" ** ")]
            self.last = statements[-1].strip(" *") if statements else self.last
            return 0

        def errorMessage(self, rowno: int, colno: int, posno: int, msg: str) -> int:  # noqa: N802
            return 0

        def progress(self, progressdata: Any) -> int:
            return 0

    return ModelData, Messages
