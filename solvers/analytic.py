"""`analytic`: the closed form, exact for every branch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from solvers.protocol import Guarantee, Question, Solution
from study.synthesis import BRANCHES, as_path, shortest
from study.verify import Claim

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class Analytic:
    """The closed form of `study.synthesis`, and of `study.kernel` for whole frames."""

    name: ClassVar[str] = "analytic"
    method: ClassVar[str] = "closed form"
    guarantee: ClassVar[Guarantee] = Guarantee.EXACT
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    warm: ClassVar[bool] = False
    packages: ClassVar[tuple[str, ...]] = ()
    summary: ClassVar[str] = "the closed form: exact, every branch, no iteration"

    def unavailable(self) -> str | None:
        return None

    def build(self, question: Question) -> Question:
        return question  # there is nothing to translate

    def solve(self, model: Question, limit: float) -> Solution:
        scenario = model.scenario
        found = shortest(scenario, model.branch)
        if found is None:
            return Solution(Claim.INFEASIBLE, message=f"no {model.branch} path exists")
        path = as_path(scenario, found.word, found.segments)
        length = path.total_length
        return Solution(Claim.OPTIMAL, path, claimed_length=length, lower_bound=length)
