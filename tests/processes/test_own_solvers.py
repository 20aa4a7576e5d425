"""The conformance kit on this package's own solvers.

Each runs in a worker process.
"""

import pytest

from dubins_study import available_solvers, check_solver
from dubins_study.conformance import CHECKS
from dubins_study.conformance.report import Status
from dubins_study.solvers.protocol import Guarantee
from dubins_study.solvers.registry import entries, load

# what an engine's variant is asked: the formulations are those of the solvers above
BRIEF = ("controls", "claims", "axis", "determinism", "state")
# that take minutes
LEFT_OUT = (
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
_BOTH = {"poses", "routes"}
# Local engines find no path from their only guess to one of the kit's poses, of three arcs, or
# along one of its routes, whose legs are the shortest: a denial, which the kit notes.
DENYING = ("collocation", "multiple-shooting", "route-nlp", "turn-rates")
# Seconds a question, for solvers that end by themselves, but on a busy machine not within 5 s.
# Killed there, they deny nothing: `turn-rates` denies after 2 s of processor time. HiGHS looks at
# its clock between steps, of which the program of 72 headings at both ends of a leg has some of a
# few seconds; the solver does not promise to keep its limit.
TIME_LIMITS = dict.fromkeys((*DENYING, "heading-milp"), 60.0)


def variants() -> list[str]:
    """The specs of other engines that can run here."""
    listed = [entry.name for entry in entries() if entry.reason is None and "[" in entry.name]
    return [name for name in listed if not any(part in name for part in LEFT_OUT)]


@pytest.mark.slow
@pytest.mark.parametrize("name", available_solvers())
def test_every_solver_passes_every_check(name):
    """Every solver passes every check.

    Notes are only about coarse answers, and about time or guesses that end before an optimum.
    """
    asked = ("loading", *BRIEF) if name in SLOW else tuple(CHECKS)
    report = check_solver(name, checks=asked, time_limit=TIME_LIMITS.get(name, 5.0))

    assert report.passed, report
    assert [result.name for result in report] == [check for check in CHECKS if check in asked]
    # `route-nlp` has one guess, which leads past the words of the discs; of poses, routes and tours
    # other local engines find no better path than from theirs, and proofs take too long
    coarse = load(name).guarantee in (Guarantee.DISCRETISED, Guarantee.STOCHASTIC)
    if not coarse and name not in ("route-nlp", *SLOW):
        notes = {result.name for result in report.with_status(Status.NOTE)}
        hard = set() if load(name).guarantee is Guarantee.EXACT else {*_BOTH, "tours"}
        assert notes <= hard, report


@pytest.mark.slow
@pytest.mark.parametrize("name", variants())
def test_every_engine_passes(name):
    spec = f"{name[:-1]},presolve=true]" if name == ENDLESS else name
    report = check_solver(spec, checks=BRIEF)

    assert report.passed, report
