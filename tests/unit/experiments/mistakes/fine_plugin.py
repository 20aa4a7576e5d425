"""A plug-in that does not fail, with one setting."""

from dataclasses import dataclass

from dubins_study import Claim, Solution, Solver


@dataclass(frozen=True)
class Fine(Solver):
    """Knows nothing."""

    name = "fine"
    size: int = 3

    def solve(self, question, limit):
        return Solution(Claim.FAILED)
