"""Whether a point that misses its equations is stationary for the violation.

Local engines that find no feasible point say so in words of their own, or in none. The slope here
is measured from the program alone, the same for all engines. It is 0 where no small change of the
variables lowers the violation to first order: a point of local infeasibility.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, vstack

from dubins_study.solvers.nlp_engines.program import NlpCall, Program
from dubins_study.solvers.runs import EngineResult
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS

# Of the linear program: the largest change of a variable. Equations that are off by less than such
# a step can mend count as met, which they are where an engine minimises the sum of the violations.
_STEP = 1e-3
_SECONDS = 0.5  # of the linear program at most; it takes 0.1 s at 200 legs


def measured(call: NlpCall) -> NlpCall:
    """The engine's call, whose result can tell the slope of the violation at its point."""

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        result = call(program, guess, seconds)
        return result._replace(slope=partial(violation_slope, program, result.x))

    return run


def violation_slope(program: Program, x: FloatArray) -> float | None:
    """How far a point, shape (n,), is from stationary for the violation of its equations.

    With multipliers y of the violation's norm and the Jacobian J, the largest entry of
    |x - clip(x - J'y / |J|, lower, upper)|, where |J| is the largest sum of a column's absolute
    entries: 0 where stationary, 1 where the most effective variable is unopposed. Of two norms, the
    sum of the violations and their Euclidean length, the one that makes it smaller counts, since
    engines minimise the one or the other. None without a point, or where it misses nothing.
    """
    if program.lower.size != x.size or not np.isfinite(x).all():
        return None
    x = np.clip(x, program.lower, program.upper)
    functions = program.functions
    g = functions.equations(x)
    low, high = program.bounds or (np.zeros(g.size), np.zeros(g.size))
    off = g - np.clip(g, low, high)
    rows, columns = functions.entries.jacobian_at
    entries = functions.entries.jacobian(x)
    if not (np.isfinite(g).all() and np.isfinite(entries).all() and off.any()):
        return None
    slopes = csr_array(coo_array((entries, (rows, columns)), shape=(g.size, x.size)))
    largest = max(float(abs(slopes).sum(axis=0).max()), EPS)
    every = [off / abs(off).max(), _sum_multipliers(program, x, slopes, high - g, g - low)]
    steps = [slopes.T @ y / largest for y in every if y is not None]
    moves = [abs(x - np.clip(x - step, program.lower, program.upper)).max() for step in steps]
    return float(min(moves))


def _sum_multipliers(
    program: Program, x: FloatArray, slopes: csr_array, above: FloatArray, below: FloatArray
) -> FloatArray | None:
    """The multipliers of min sum t, -t - below <= J d <= t + above over small steps d, or None."""
    from scipy.optimize import linprog

    m, n = slopes.shape
    slack = eye_array(m)
    rows = vstack([_beside(slopes, -slack), _beside(-slopes, -slack)])
    ends = np.concatenate([above, below])
    low = np.minimum(np.maximum(program.lower - x, -_STEP), 0.0)
    high = np.maximum(np.minimum(program.upper - x, _STEP), 0.0)
    bounds = np.concatenate([np.stack([low, high], axis=1), [(0.0, np.inf)] * m])
    cost = np.concatenate([np.zeros(n), np.ones(m)])
    solved = linprog(cost, rows, ends, bounds=bounds, options={"time_limit": _SECONDS})
    if solved.status != 0:
        return None
    multipliers = -np.asarray(solved.ineqlin.marginals)
    return np.asarray(multipliers[:m] - multipliers[m:])


def _beside(left: csr_array, right: csr_array) -> csr_array:
    """Two matrices side by side."""
    return csr_array(vstack([left.T, right.T]).T)
