"""The slope of the violation at an infeasible point.

Local engines that find no feasible point report this in words of their own, or not at all. The
slope here is measured from the program alone, the same for all engines. It is 0 where no small
change of the variables lowers the violation to first order: a point of local infeasibility.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from dubins_study.solvers.nlp_engines.program import NlpCall, Program
from dubins_study.solvers.runs import EngineResult
from dubins_study.study.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_STEP = 1.0  # radians, or radii: the natural unit of every variable
_SECONDS = 0.5  # of the linear program at most; it takes 0.1 s at 200 legs
_MOST = 400  # variables up to which the Euclidean length is tried too


def measured(call: NlpCall) -> NlpCall:
    """The engine's call, with `slope` in each result.

    The field `slope` is a function that computes the violation's slope at the result's point.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        result = call(program, guess, seconds)
        return result._replace(slope=partial(violation_slope, program, result.x))

    return run


def violation_slope(program: Program, x: FloatArray) -> float | None:
    """The violation's share that a small step removes.

    The point x has shape (n,), and the step has at most size 1 in each variable and stays within
    the bounds. The equations are replaced by their linear model. The slope is 0 where the point is
    stationary for the violation, and 1 where the model can be mended. The model's violation is
    convex in the step, so that it is 0 for a box of this size if and only if it is for any other.
    Both the sum of the violations and their Euclidean length are tried, since engines minimise the
    one or the other; the smaller share counts. None without a point, or where it misses nothing.
    """
    from scipy.sparse import coo_array, csr_array

    if program.lower.size != x.size or not np.isfinite(x).all():
        return None
    x = np.clip(x, program.lower, program.upper)
    functions = program.functions
    g = functions.equations(x)
    low, high = program.bounds or (np.zeros(g.size), np.zeros(g.size))
    violation = g - np.clip(g, low, high)
    rows, columns = functions.entries.jacobian_at
    entries = functions.entries.jacobian(x)
    if not (np.isfinite(g).all() and np.isfinite(entries).all() and violation.any()):
        return None
    slopes = csr_array(coo_array((entries, (rows, columns)), shape=(g.size, x.size)))
    box = np.maximum(program.lower - x, -_STEP), np.minimum(program.upper - x, _STEP)
    # the shares of the violation that no step removes; NaN where a program was not solved
    remaining = [_least_sum(slopes, high - g, g - low, box) / abs(violation).sum()]
    if x.size <= _MOST and program.bounds is None:
        remaining.append(_least_length(slopes, violation, box) / float(np.linalg.norm(violation)))
    return float(np.clip(1.0 - np.nanmax([0.0, *remaining]), 0.0, 1.0))


def _least_sum(
    slopes: csr_array, above: FloatArray, below: FloatArray, box: tuple[FloatArray, FloatArray]
) -> float:
    """The least sum of violations over a box.

    The linear program is min sum t over steps d in the box, with -t - below <= J d <= t + above.
    Here `above` is the upper end less g, and `below` is g less the lower end, shape (m,). NaN if it
    is not solved.
    """
    from scipy.optimize import linprog
    from scipy.sparse import csr_array, eye_array, hstack, vstack

    m, n = slopes.shape
    slack = eye_array(m)
    rows = csr_array(vstack([hstack([slopes, -slack]), hstack([-slopes, -slack])]))
    bounds = np.concatenate([np.stack(box, axis=1), [(0.0, np.inf)] * m])
    cost = np.concatenate([np.zeros(n), np.ones(m)])
    ends = np.concatenate([above, below])
    finite = np.flatnonzero(np.isfinite(ends))
    options = {"time_limit": _SECONDS}
    solved = linprog(cost, rows[finite], ends[finite], bounds=bounds, options=options)
    if solved.status != 0:
        return np.nan
    return float(solved.fun)


def _least_length(slopes: csr_array, off: FloatArray, box: tuple[FloatArray, FloatArray]) -> float:
    """The least Euclidean length of off + J d.

    The steps d are in a box.
    """
    from scipy.optimize import lsq_linear

    free = box[1] > box[0]
    solved = lsq_linear(slopes.toarray()[:, free], -off, bounds=(box[0][free], box[1][free]))
    return float(np.linalg.norm(solved.fun))
