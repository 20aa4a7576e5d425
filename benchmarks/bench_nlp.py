"""`slsqp` and `ipopt` beside loops written by hand.

All solve the same problems from the same starts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import casadi
import numpy as np
from scipy.optimize import minimize

from benchmarks.harness import Measurement, side_by_side, sized
from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.one_leg.initial_guesses import initial_guesses
from dubins_study.solvers.one_leg.model import Case, equations, jacobian, posed_leg
from dubins_study.solvers.paper_nlp.nlp import Ipopt, Slsqp
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.setting_checks import nested
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.scenario import Scenario

N = sized(1_000, 3)
TARGET = 1.1


class Job(NamedTuple):
    """Input of the hand-written loops for one solve."""

    X: float
    Y: float
    free: list[int]
    start: FloatArray


def questions() -> list[Question]:
    """Targets 5 to 100 radii away.

    LS and RS are solved from their first start there.
    """
    rng = np.random.default_rng(0)
    distance = 10 ** rng.uniform(0.7, 2, N)
    bearing = rng.uniform(-math.pi, math.pi, N)
    return [
        Question(Scenario(0, 0, 0, d * math.cos(b), d * math.sin(b), 1))
        for d, b in zip(distance, bearing, strict=True)
    ]


def jobs(asked: list[Question]) -> list[Job]:
    """The same problems and starts.

    They are made before the clock runs.
    """

    def job(question: Question, case: Case) -> Job:
        start = next(initial_guesses(question, case, "bearing", 0, 1))
        return Job(case.target.X, case.target.Y, list(case.subproblem.free), start)

    posed = [posed_leg(question, "words", "both", presolve=True) for question in asked]
    return [job(leg.question, case) for leg in posed for case in leg.cases]


def ours(solver: Solver, asked: list[Question]) -> None:
    for question in asked:
        solver.solve(solver.build(question), 60.0)


def slsqp_by_hand(work: list[Job]) -> None:
    """`scipy.optimize.minimize` with the same functions, bounds, starts and tolerance."""
    ones = np.ones(2)

    def full(z: FloatArray, free: list[int]) -> FloatArray:
        lengths = np.zeros(3)
        lengths[free] = z
        return lengths

    for X, Y, free, start in work:
        constraint: dict[str, Any] = {
            "type": "eq",
            "fun": lambda z, X=X, Y=Y, free=free: equations(full(z, free), X, Y),
            "jac": lambda z, free=free: jacobian(full(z, free))[:, free],
        }
        minimize(
            np.sum,
            start[free],
            jac=lambda z: ones,
            method="SLSQP",
            bounds=[(0.0, TWO_PI), (0.0, math.inf)],
            constraints=constraint,
            options=ENGINES["slsqp"].options.of("equal"),
        )


def ipopt_by_hand(work: list[Job], solver: Any) -> None:
    """Solve by casadi and Ipopt.

    Whether it succeeded is asked too, since no result says it unasked.
    """
    for X, Y, free, start in work:
        upper = [0.0, 0.0, 0.0]
        for i in free:
            upper[i] = TWO_PI if i < 2 else math.inf
        solver(x0=start, p=(X, Y), lbx=0, ubx=upper, lbg=0, ubg=0)
        solver.stats()["success"]


def casadi_solver() -> Any:
    """Model (4.12) in casadi, with the target as parameter."""
    z = casadi.SX.sym("z", 3)
    p = casadi.SX.sym("p", 2)
    z1 = z[0]
    th = z[0] - z[1]
    z3 = z[2]
    x_end = 2 * casadi.sin(z1) - casadi.sin(th) + z3 * casadi.cos(th)
    y_end = 1 - 2 * casadi.cos(z1) + casadi.cos(th) + z3 * casadi.sin(th)
    nlp = {
        "x": z,
        "p": p,
        "f": casadi.sum1(z),
        "g": casadi.vertcat(p[0] - x_end, p[1] - y_end),
    }
    options = nested(ENGINES["ipopt"].options.of("equal"))
    return casadi.nlpsol("hand", "ipopt", nlp, {"print_time": False, **options})


def measure() -> Iterable[Measurement]:
    asked = questions()
    work = jobs(asked)
    # the loops by hand solve the words that the presolve leaves
    slsqp, ipopt = Slsqp(presolve=True), Ipopt(presolve=True)
    by_hand = casadi_solver()
    pairs = {
        "slsqp, against bare scipy.optimize.minimize": (
            lambda: ours(slsqp, asked),
            lambda: slsqp_by_hand(work),
        ),
        "ipopt, against casadi and Ipopt by hand": (
            lambda: ours(ipopt, asked),
            lambda: ipopt_by_hand(work, by_hand),
        ),
    }
    for what, (mine, peer) in pairs.items():
        times = side_by_side({"ours": mine, "peer": peer}, repeats=5)
        yield Measurement(
            what=f"{what}, {N} scenarios",
            ours=times["ours"].least / N * 1e3,
            peer=times["peer"].least / N * 1e3,
            unit="ms/scenario",
            ratio=times["ours"].least / times["peer"].least,
            target=TARGET,
            note=f"ours / peer; of medians {times['ours'].median / times['peer'].median:.2f}",
        )
