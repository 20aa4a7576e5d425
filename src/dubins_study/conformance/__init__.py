"""Check that a solver keeps its promise.

The promise is in `solvers/protocol.py`. Where a solver does not keep it, the report explains why.

`check_solver(solver)` puts 40 to 90 questions to a solver, by what it answers, in a worker process
and returns a `ConformanceReport`. `CHECKS` are the names of its checks, for
`pytest.mark.parametrize`.
"""

from dubins_study.conformance.checks import CHECKS as CHECKS
from dubins_study.conformance.checks import check_solver as check_solver
from dubins_study.conformance.report import ConformanceReport as ConformanceReport

__all__ = ["CHECKS", "ConformanceReport", "check_solver"]
