"""MAiNGO by its Python interface.

It is a deterministic global optimiser that uses McCormick relaxations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.minlp_engines.mixed_program import (
    MinlpCall,
    MixedProgram,
    ProvenResult,
    Settings,
)
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.words import Claim


def maingo(settings: Settings) -> MinlpCall:
    """A call of MAiNGO with the given settings.

    The settings become epsilonR, epsilonA, deltaEq and deltaIneq.
    """

    def run(program: MixedProgram, seconds: float) -> ProvenResult:
        import maingopy

        model = _model_class()(program)  # kept: MAiNGO does not keep Python's half of it alive
        solver = maingopy.MAiNGO(model)
        options = {
            "epsilonR": settings.gap,
            "epsilonA": settings.gap,
            "deltaEq": settings.feastol,
            "deltaIneq": settings.feastol,
            "maxTime": _whole_seconds(seconds),
            "BAB_verbosity": maingopy.VERB_NONE,
            "LBP_verbosity": maingopy.VERB_NONE,
            "UBP_verbosity": maingopy.VERB_NONE,
            "loggingDestination": maingopy.LOGGING_NONE,
            "writeResultFile": False,  # into whatever folder the process is in
        }
        for name, value in options.items():
            assert solver.set_option(name, value), name
        status = solver.solve().name
        return _result(solver, status)

    return run


def _whole_seconds(seconds: float) -> int:
    """The time limit in MAiNGO's unit, rounded down.

    MAiNGO then ends before the limit. With 0 it would end after its first local searches, where
    most questions take it 0.1 s in all. So the last part of a second is passed on as a whole
    second. An answer after the limit is no answer.
    """
    if 0 < seconds < 1:
        return 1
    return max(int(seconds), 0)


def _result(solver: Any, status: str) -> ProvenResult:
    claim = claim_of("maingo", status)
    point = None
    if status in ("GLOBALLY_OPTIMAL", "BOUND_TARGETS", "FEASIBLE_POINT"):
        point = np.array(solver.get_solution_point(), dtype=np.float64)
    bound = float(solver.get_final_LBD())
    if claim is Claim.INFEASIBLE:
        bound = math.inf
    elif bound <= -1e300:  # MAiNGO's number for no bound
        bound = -math.inf
    return ProvenResult(
        point,
        claim,
        bound,
        nodes=int(solver.get_iterations()),
        iterations=None,
        status=status,
        message=status.replace("_", " ").lower(),
    )


@cache
def _model_class() -> type[Any]:
    """The class whose objects hand a program to MAiNGO.

    The class extends one of the package's, so it is made when the package is first needed.
    """
    import maingopy

    class Posed(maingopy.MAiNGOmodel):  # type: ignore[misc]
        def __init__(self, program: MixedProgram) -> None:
            super().__init__()
            self.program = program

        def get_variables(self) -> list[Any]:
            kinds = maingopy.VT_CONTINUOUS, maingopy.VT_BINARY
            return [
                maingopy.OptimizationVariable(maingopy.Bounds(lower, upper), kinds[binary])
                for lower, upper, binary in self.program.variables
            ]

        def evaluate(self, variables: Sequence[Any]) -> Any:
            written = self.program.write(variables, maingopy)
            result = maingopy.EvaluationContainer()
            result.objective = written.objective
            rows = written.rows
            # MAiNGO reads eq = 0 and ineq <= 0
            result.eq = [body - lower for body, lower, upper in rows if lower == upper]
            result.ineq = [
                *(body - upper for body, lower, upper in rows if lower < upper < math.inf),
                *(lower - body for body, lower, upper in rows if -math.inf < lower < upper),
            ]
            return result

    return Posed
