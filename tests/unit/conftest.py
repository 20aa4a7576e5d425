"""Unit tests start no process.

They ask our own solvers in their own process, but for OR-tools'.
"""

import pytest

from dubins_study.experiments import solve as asking
from dubins_study.solvers.engines import EngineSolver
from dubins_study.solvers.protocol import Solver


@pytest.fixture(autouse=True, scope="package")
def _asked_here():
    """Ask solvers here, without a worker.

    A worker would load a solver's libraries anew for each question: a second for cvxpy.

    `tests/processes` has the tests of workers and of limits.
    """
    in_worker = asking._in_worker

    def here(solver, isolated, *, frames=False):
        # OR-tools and highspy cannot be loaded in one process
        chosen = isolated
        if isolated is None and isinstance(solver, Solver):
            chosen = isinstance(solver, EngineSolver) and "ortools" in solver.library.packages
        return in_worker(solver, chosen, frames=frames)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(asking, "_in_worker", here)
        yield
