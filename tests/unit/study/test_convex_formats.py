"""Convex problems as QPS and CBF.

Programs that share nothing with the writer read them back.
"""

import highspy
import numpy as np
import pytest
from scipy.sparse import coo_array

from dubins_study.study.convex.formats import cbf_text, qps_text
from dubins_study.study.convex.problem import ProblemError, read
from dubins_study.study.convex.proof import reference

cp = pytest.importorskip("cvxpy")


@pytest.mark.parametrize("name", ["qp-50-random-6-0", "qp-50-survey-3-3"])
def test_highs_reads_a_qps_file(name, tmp_path):
    """HiGHS reads a QPS file.

    It reads the numbers of the problem, and its optimum lies in the proven interval.
    """
    problem = read(name)
    file = tmp_path / "problem.mps"
    file.write_text(qps_text(problem, name))
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.setOptionValue("time_limit", 5.0)

    # it leaves out entries of the matrix below 1e-9, with a warning
    assert solver.readModel(str(file)) != highspy.HighsStatus.kError
    model = solver.getModel()
    solver.run()
    low, high = reference(name)

    assert np.array_equal(model.lp_.col_cost_, problem.q)
    assert np.array_equal(model.lp_.col_lower_, problem.lb)
    assert np.array_equal(model.lp_.col_upper_, problem.ub)
    large = np.abs(problem.A.data) > 1e-9
    assert sorted(model.lp_.a_matrix_.value_) == sorted(problem.A.data[large])
    assert sorted(filter(None, model.hessian_.value_)) == sorted(problem.p[problem.p != 0])
    assert low - 1e-6 <= solver.getInfo().objective_function_value <= high + 1e-6


def test_a_problem_with_cones_has_no_qps():
    """A problem with cones has no QPS.

    The refusal names the problem and the format that can say it.
    """
    with pytest.raises(ProblemError, match=r"time-50-survey-6 has cones.*CBF"):
        qps_text(read("time-50-survey-6"), "time-50-survey-6")


def cbf_optimum(text):
    """Least value of a CBF file, by cvxpy.

    The reader knows these sections only.
    """
    blocks = dict(block.split("\n", 1) for block in text.strip().split("\n\n"))

    def table(name):
        lines = blocks[name].strip().split("\n")
        assert len(lines) - 1 == int(lines[0].split()[-1])
        return int(lines[0].split()[0]), [line.split() for line in lines[1:]]

    n, (free,) = table("VAR")
    assert (blocks["VER"].strip(), blocks["OBJSENSE"].strip()) == ("3", "MIN")
    assert free == ["F", str(n)]
    m, cones = table("CON")
    cost = np.zeros(n)
    b = np.zeros(m)
    for place, value in table("OBJACOORD")[1]:
        cost[int(place)] = float(value)
    for place, value in table("BCOORD")[1]:
        b[int(place)] = float(value)
    rows, columns, values = zip(*table("ACOORD")[1], strict=True)
    A = coo_array((np.array(values, float), (np.array(rows, int), np.array(columns, int))), (m, n))
    x = cp.Variable(n)
    inside = A.tocsr() @ x + b
    says = {
        "L=": lambda s: s == 0,
        "L-": lambda s: s <= 0,
        "L+": lambda s: s >= 0,
        "Q": lambda s: cp.SOC(s[0], s[1:]),
        "QR": lambda s: cp.quad_over_lin(s[2:], s[1]) <= 2 * s[0],
    }
    first = 0
    constraints = []
    for cone, size in cones:
        constraints.append(says[cone](inside[first : first + int(size)]))
        first += int(size)
    assert first == m
    return cp.Problem(cp.Minimize(cost @ x), constraints).solve(solver="ECOS")


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")  # to ECOS's own 1e-8
@pytest.mark.parametrize(
    "name", ["qp-50-random-6-0", "tube-50-cluster-9-38", "time-50-survey-6", "trivial"]
)
def test_a_cbf_file_has_the_proven_optimum(name):
    """A CBF file has the proven optimum.

    What a reader of its own makes of the file is solved to the proven interval.
    """
    low, high = reference(name)

    assert low - 1e-6 <= cbf_optimum(cbf_text(read(name))) <= high + 1e-6
