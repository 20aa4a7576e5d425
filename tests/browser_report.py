"""A small report with every kind of section.

The browser's tests share it.
"""

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study import render
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, paper_scenarios, write_folder

# A script, TeX, Markdown, a spreadsheet's formula, a new line, marks that turn the text around, and
# letters that are read from right to left.
HOSTILE = (
    "</script><script>alert('x')</script>\n& |a_b| $x^2$ \\input{y} `c` =1+1 \u202eabc\u2066 שלום"
)
LONG = "x" * 150  # a name in which no line can break

_STRATA = {
    "outside, far": [(40, 9), (-60, 30), (25, -70), (90, 1)],
    "outside, near": [(3, 1), (2.5, -2), (-2, 2.6), (0.5, 3)],
    "inside a disc": [(0.2, 0.9), (-0.3, 1.2), (0.3, -0.8), (0.1, 1.5)],
    "near a circle": [(1.0005, 1), (-1.0002, 1), (1.0003, -1), (0.0001, 2.0003)],
}


class Method(NamedTuple):
    """One made-up solver and its errors.

    Every `wrong`-th answer misses (0: none); each takes a time (s).
    """

    solver: str
    formulation: str
    engine: str
    guess: str
    wrong: int
    wall_s: float
    claim: Claim = Claim.LOCAL


METHODS = (
    Method("analytic", "closed form", "dubins-study", "none", 0, 3e-5, Claim.OPTIMAL),
    Method("slsqp[presolve=true]", "one NLP a word", "SLSQP", "bearing", 0, 2e-3),
    Method("ipopt[presolve=true]", "one NLP a word", "Ipopt", "bearing", 7, 5e-3),
    Method(
        "slsqp[model=joint,order=LRS,initial_guess=zero]",
        *("joint NLP, LRS", "SLSQP", "zero", 2, 1e-3),
    ),
    Method(
        "ipopt[model=joint,order=LRS,initial_guess=zero]",
        *("joint NLP, LRS", "Ipopt", "zero", 3, 4e-3),
    ),
    Method("turn-rate-qp[presolve=true]", "turn rates", "PIQP", "bearing", 4, 2e-2),
    Method("shooting[presolve=true]", "Pontryagin's system", "MINPACK hybr", "bearing", 9, 3e-3),
    Method("disjunctive", "disjunction", "SCIP", "none", 0, 2e-1, Claim.OPTIMAL),
    Method("penalty[engine=direct]", "penalty", "DIRECT", "none", 2, 5e-1),
)


def benchmark_rows() -> Iterator[dict[str, Any]]:
    """Rows like the benchmark's.

    Sixteen scenarios in four strata, asked of nine methods.
    """
    number = 0
    for stratum, targets in _STRATA.items():
        for x, y in targets:
            scenario = Scenario(0, 0, 0, x, y, 1, label=stratum)
            number += 1
            for place, method in enumerate(METHODS):
                wrong = method.wrong and (number + place) % method.wrong == 0
                shortest = shortest_path(scenario, "best")
                assert shortest is not None
                yield attempt(
                    scenario,
                    method.solver,
                    path=Path(scenario.start, [0.0], [1.0]) if wrong else "exact",
                    claim=Claim.FAILED if wrong else method.claim,
                    scenario_id=f"{number:08x}",
                    formulation=method.formulation,
                    engine=method.engine,
                    guess=method.guess,
                    wall_s=method.wall_s * (1 + number / 40),
                    evaluations=int(1e4 * method.wall_s) + number,
                    lower_bound=shortest.length if method.claim is Claim.OPTIMAL else None,
                    message=f"{HOSTILE} {LONG}" if wrong else "",
                )


def sweep_rows() -> Iterator[dict[str, Any]]:
    """Rows of problem 5 through its crossing.

    The label comes from outside.
    """
    for radius in (20.0, 40.0, 55.0, 60.0, 80.0):
        scenario = Scenario(0, 0, 2.0943951023931953, -80, 20, radius, label=HOSTILE)
        for solver in ("analytic", "slsqp", HOSTILE, LONG):
            yield attempt(scenario, solver, engine=solver)


def paper_rows() -> Iterator[dict[str, Any]]:
    """The paper's problems by two solvers.

    One is the closed form.
    """
    for scenario in paper_scenarios():
        for branch in ("best", "LS", "RS"):
            yield attempt(scenario, branch=branch)
            yield attempt(scenario, "slsqp", branch, claim=Claim.LOCAL)


def small_report(place: FilePath) -> FilePath:
    """Write the report of these rows below a folder.

    Returns the path of its page.
    """
    rows = {"benchmark": benchmark_rows(), "paper": paper_rows(), "radius-sweep": sweep_rows()}
    folders = [write_folder(place / name, name, each) for name, each in rows.items()]
    return render(folders, out=place / "report")
