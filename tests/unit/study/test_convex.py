"""Frozen convex problems and their proven bounds.

Tested are files, residuals, and bounds beside optima known otherwise.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.sparse import csr_array

from benchmarks.freeze_convex import write
from dubins_study.study.convex.problem import Point, Problem, ProblemError, listed, parse, read
from dubins_study.study.convex.proof import (
    judge_convex,
    lower_bound,
    reference,
    residuals,
    upper_bound,
)
from dubins_study.study.words import Claim, Verdict

# one of each size, but the largest, and family
SAMPLE = (
    "qp-50-cluster-10-12",
    "qp-500-survey-6-3",
    "tube-50-cluster-9-38",
    "tube-500-random-5-14",
    "time-50-survey-6",
    "time-500-random-20",
)
EMPTY = np.zeros(0)


def disc(radius: float) -> Problem:
    """Minimise x + y over a disc around 0.

    The optimum is -radius sqrt(2), at equal coordinates.
    """
    d = np.array([radius, 0.0, 0.0])
    C = csr_array(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    ends = np.full(2, 3.0 * radius)
    return Problem(
        p=np.zeros(2), q=np.ones(2), A=csr_array((0, 2)), l=EMPTY, u=EMPTY, lb=-ends, ub=ends,
        C=C, d=d, cones=np.array([3]), interior=np.zeros(2), x=EMPTY, y=EMPTY, z=EMPTY, w=EMPTY,
    )  # fmt: skip


def test_bounds_enclose_an_optimum_known_by_hand():
    """Bounds enclose an optimum known by hand.

    Minimising x + y over a disc of radius 2 gives -2 sqrt(2).
    """
    problem = disc(2.0)
    optimum = -2 * np.sqrt(2)
    side = 1 / np.sqrt(2)
    best = Point(np.full(2, -2 * side), EMPTY, np.zeros(2), np.array([np.sqrt(2), 1.0, 1.0]))

    low, high = lower_bound(problem, best), upper_bound(problem, best.x)

    assert low <= optimum <= high
    assert high - low < 1e-11
    assert max(residuals(problem, best)) < 1e-14


def test_bounds_hold_for_any_point():
    """Bounds hold for any point.

    However wrong a point is, its bounds stay on their sides of the optimum.
    """
    problem = disc(2.0)
    random = np.random.default_rng(5)
    for size in (1e-8, 1e-3, 1.0, 1e3):
        x = size * random.normal(size=2)
        w = size * random.normal(size=3)
        assert upper_bound(problem, x - np.sqrt(2)) >= -2 * np.sqrt(2) - 1e-15
        assert lower_bound(problem, Point(x, EMPTY, EMPTY, w)) <= -2 * np.sqrt(2) + 1e-15


@pytest.mark.parametrize(
    "name",
    [name if name in SAMPLE else pytest.param(name, marks=pytest.mark.slow) for name in listed()],
)
def test_reference_is_closed(name):
    """Reference intervals are closed.

    Every packaged problem comes with a proof of its optimum to 1e-9.
    """
    low, high = reference(name)

    assert 0 <= high - low <= 1e-9


def test_every_size_and_family_has_problems():
    """Every size and family has problems.

    There are some hundred; a small one has a tenth of the variables of the next size.
    """
    parts = [name.split("-")[:2] for name in listed() if name != "trivial"]

    assert len(parts) == 100
    for family, least in (("qp", 12), ("tube", 4), ("time", 4)):
        assert all(parts.count([family, size]) >= least for size in ("50", "500", "5000"))


def test_an_equation_is_closed_by_its_own_variable():
    """An equation is closed by its own variable.

    Of x = 1/3 over y + x with x in [0, 1] the proof takes x for what closes it, not a float.
    """
    A = csr_array(np.array([[3.0, -1.0]]))
    none = csr_array((0, 2))
    problem = Problem(
        p=np.zeros(2), q=np.array([1.0, 0.0]), A=A, l=np.array([0.1]), u=np.array([0.1]),
        lb=np.zeros(2), ub=np.ones(2), C=none, d=EMPTY, cones=np.zeros(0, dtype=int),
        interior=np.array([0.2, 0.5]), x=EMPTY, y=EMPTY, z=EMPTY, w=EMPTY,
    )  # fmt: skip

    high = upper_bound(problem, np.array([0.0, 0.7]))
    low = lower_bound(problem, Point(EMPTY, np.array([-1 / 3]), EMPTY, EMPTY))

    assert low <= 0.1 / 3 <= high <= low + 1e-10


@pytest.mark.parametrize("name", SAMPLE[:2])
def test_feasible_value_agrees_with_another_engine(name):
    """The feasible value agrees with another engine.

    Without its quadratic term a QP is an LP, which HiGHS solves by way of SciPy.
    """
    problem = read(name)
    flat = replace(problem, p=np.zeros_like(problem.p))
    rows = ~problem.equal
    solved = linprog(
        flat.q,
        A_ub=flat.A[rows], b_ub=flat.u[rows], A_eq=flat.A[~rows], b_eq=flat.u[~rows],
        bounds=np.column_stack((flat.lb, flat.ub)),
    )  # fmt: skip
    y = np.zeros(flat.l.size)
    y[rows] = -solved.ineqlin.marginals
    y[~rows] = -solved.eqlin.marginals

    # HiGHS keeps rows and reduced costs to 1e-7
    low = lower_bound(flat, Point(solved.x, y, EMPTY, EMPTY))
    assert upper_bound(flat, solved.x) == pytest.approx(solved.fun, abs=1e-6)
    assert low == pytest.approx(solved.fun, abs=1e-6)


@pytest.mark.parametrize("name", [name for name in SAMPLE if "-50-" in name])
def test_verdicts(name):
    """Verdicts on a witness and a moved point.

    The witness is optimal; the same point moved is longer, or misses.
    """
    problem = read(name)
    numbers = np.concatenate(problem.witness)
    tolerance = 1e-6
    steps = {Verdict.OPTIMAL: 0.0, Verdict.LONGER: 0.5}
    for verdict, step in steps.items():
        moved = numbers.copy()
        moved[: problem.q.size] += step * (problem.interior - problem.x)
        judgement, certificate = judge_convex(name, moved, Claim.OPTIMAL, tolerance)
        assert judgement.verdict is verdict
        assert judgement.false_claim is (verdict is not Verdict.OPTIMAL)
        assert certificate.reference_low <= judgement.length
    outside = numbers.copy()
    outside[0] = problem.ub[0] + 1e-5

    assert judge_convex(name, outside, Claim.LIMIT, tolerance)[0].verdict is Verdict.MISSES
    assert judge_convex(name, None, Claim.NONE, tolerance)[0].verdict is Verdict.NONE
    assert judge_convex("no such", numbers, Claim.OPTIMAL, 1e-6)[0].verdict is Verdict.NONE


def test_a_file_comes_back_as_it_was_written(tmp_path):
    """A file comes back as it was written.

    Writing and reading keeps every number, and the same problem gives the same bytes.
    """
    problem = disc(1.5)
    file = tmp_path / "disc.npz"
    digest = write(problem, file)
    back = parse(file.read_bytes(), "disc")

    assert (back.C.toarray() == problem.C.toarray()).all()
    assert back.d.tolist() == problem.d.tolist()
    assert write(back, file) == digest


def test_what_is_no_problem_is_refused(tmp_path):
    """Files of other content are refused.

    So are unknown names; both are refused by name.
    """
    np.savez(tmp_path / "other.npz", p=np.ones(2))
    with pytest.raises(ProblemError, match="other"):
        parse((tmp_path / "other.npz").read_bytes(), "other")
    with pytest.raises(ProblemError, match="no convex problem named 'qp-1'"):
        read("qp-1")
