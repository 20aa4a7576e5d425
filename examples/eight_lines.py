"""A solver in eight lines.

It turns once, to the side of the target, and drives straight on.
"""

from math import copysign

import numpy as np
from scipy.optimize import root

from dubins_study import Claim, Path, Solution, Solver


class EightLines(Solver):
    name = "eight-lines"

    def solve(self, question, limit):
        s = question.scenario
        k, goal = [copysign(1 / s.radius, s.local()[1]), 0], (s.target_x, s.target_y)
        z = root(lambda z: np.subtract(Path(s.start, k, abs(z)).end[:2], goal), 2 * [2 * s.radius])
        claim = Claim.FEASIBLE if z.success else Claim.FAILED
        return Solution(claim, Path(s.start, k, abs(z.x)))
