"""The conformance kit on this package's own solvers, each in a worker process."""

import pytest

from dubins_study import available_solvers, check_solver
from dubins_study.conformance import CHECKS
from dubins_study.conformance.report import Status
from dubins_study.solvers.protocol import Guarantee
from dubins_study.solvers.registry import entries, load

# what an engine's variant is asked: the formulations are those of the solvers above
BRIEF = ("controls", "claims", "axis", "determinism", "state")
# whose licence does not let rows be published, or that take minutes
LEFT_OUT = (
    "gurobi",
    "xpress",
    "cobyla",
    "cobyqa",
    "sleqp",
    "shgo",
    "apopt",
    "trust-constr",
)
# trust-constr, its default engine, has no test for infeasibility and spends the limit on words that
# have no path: asked everything, it takes minutes
SLOW = ("nlp",)
# does not end on words that have no path, and is asked with its presolve
ENDLESS = "nlp[engine=nlopt-slsqp]"


def variants() -> list[str]:
    """The specs of other engines that can run here."""
    listed = [entry.name for entry in entries() if entry.reason is None and "[" in entry.name]
    return [name for name in listed if not any(part in name for part in LEFT_OUT)]


@pytest.mark.slow
@pytest.mark.parametrize("name", available_solvers())
def test_every_solver_passes_every_check(name):
    """With no note but for coarse answers, and where time or guesses end before an optimum."""
    asked = ("loading", *BRIEF) if name in SLOW else tuple(CHECKS)
    report = check_solver(name, checks=asked)

    assert report.passed, report
    assert [result.name for result in report] == [check for check in CHECKS if check in asked]
    # `route-nlp` has one guess, which leads past the words of the discs
    coarse = load(name).guarantee in (Guarantee.DISCRETISED, Guarantee.STOCHASTIC)
    if not coarse and name not in ("route-nlp", *SLOW):
        assert report.with_status(Status.NOTE) == (), report


@pytest.mark.slow
@pytest.mark.parametrize("name", variants())
def test_every_engine_passes(name):
    spec = f"{name[:-1]},presolve=true]" if name == ENDLESS else name
    report = check_solver(spec, checks=BRIEF)

    assert report.passed, report
