"""Uno by its makers' wheel `unopy`, as filterSQP."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import NlpCall, Program
from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray


def filtersqp(options: OptionValues) -> NlpCall:
    """A call of filterSQP as Uno rebuilds it.

    The method is Fletcher and Leyffer's, with their QP solver BQPD.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        import unopy

        solver = unopy.UnoSolver()
        solver.set_preset("filtersqp")
        chosen = program.attainable(options, "primal_tolerance")
        for name, value in {**chosen, "time_limit": float(seconds)}.items():
            solver.set_option(name, value)
        result = solver.optimize(_model(program, guess))
        # the first status is how it stopped; the second, of the point, counts if it ended by itself
        status = result.optimization_status.name
        if status == "SUCCESS":
            status = result.solution_status.name
        return EngineResult(
            np.array(result.primal_solution),
            claim_of("uno-filtersqp", status),
            np.array(result.constraint_dual_solution),
            iterations=int(result.number_iterations),
            evaluations=int(
                result.number_constraint_evaluations or result.number_objective_evaluations
            ),
            status=status,
            message=status.replace("_", " ").lower(),
        )

    return run


def _model(program: Program, guess: FloatArray) -> Any:
    """The program in Uno's form.

    Derivatives are given by entries. The Lagrangian is f + multipliers g.
    """
    import unopy

    functions = program.functions
    entries = functions.entries
    n = guess.size
    m = functions.equations(guess).size

    # Uno passes to each function the array to fill
    def filling(function: Callable[[FloatArray], FloatArray]) -> Callable[[Any, Any], None]:
        def fill(x: Any, values: Any) -> None:
            values[:] = function(np.asarray(x))

        return fill

    def hessian(x: Any, weight: float, multipliers: Any, values: Any) -> None:
        # the weight is 0 while Uno looks for a feasible point
        values[:] = entries.hessian(np.asarray(x), weight, np.asarray(multipliers))

    model = unopy.Model("NLP", n, program.lower, program.upper, unopy.ZERO_BASED_INDEXING)
    model.set_objective(
        unopy.MINIMIZE,
        lambda x: float(functions.objective(np.asarray(x))),
        filling(functions.gradient),
    )
    zeros = np.zeros(m)
    rows, columns = entries.jacobian_at.tolist()
    equations = filling(functions.equations)
    jacobian = filling(entries.jacobian)
    model.set_constraints(m, equations, zeros, zeros, len(rows), rows, columns, jacobian)
    rows, columns = entries.hessian_at.tolist()
    model.set_lagrangian_hessian(len(rows), unopy.LOWER_TRIANGLE, rows, columns, hessian)
    model.set_lagrangian_sign_convention(unopy.MULTIPLIER_POSITIVE)
    model.set_initial_primal_iterate(guess)
    return model
