"""How workers fare with the solvers that they load, and what follows for the cells to come."""

from __future__ import annotations

from dubins_study.experiments.isolation.endings import again
from dubins_study.experiments.plan.cells import Cell
from dubins_study.solvers.attempt import Reply, nothing


class Loading:
    """Which solvers are loaded without a warm-up, and which are not tried again.

    Args:
        warm_up: whether solvers are asked an easy question before the first of their own.
    """

    def __init__(self, warm_up: bool):
        self._warm_up = warm_up
        # solvers whose warm-up ended a worker
        self._cold: set[tuple[str, str]] = set()
        # those that ended a worker as it loaded them, with the reply that stands for all cells
        self._hopeless: dict[tuple[str, str], Reply] = {}
        self._answered: set[tuple[str, str]] = set()

    def warms_up(self, cell: Cell) -> bool:
        """Whether a worker that loads a cell's solver warms it up."""
        return self._warm_up and _solver(cell) not in self._cold

    def reply(self, cell: Cell) -> Reply | None:
        """What is replied for a cell whose solver is not tried again."""
        known = self._hopeless.get(_solver(cell))
        return None if known is None else again(known)

    def answered(self, cell: Cell) -> None:
        """A cell's solver has been loaded, and has replied."""
        self._answered.add(_solver(cell))

    def failed(self, cell: Cell, warmed_up: bool, reply: Reply) -> Reply | None:
        """The reply for a cell whose solver ended the worker as it was loaded; None: ask again."""
        if warmed_up:
            self._cold.add(_solver(cell))
            return None
        message, status = reply.solution.message, reply.solution.native_status
        reply = nothing(reply.outcome, f"{message}, while it was loaded", status=status)
        if _solver(cell) not in self._answered:
            self._hopeless[_solver(cell)] = reply
        return reply


def _solver(cell: Cell) -> tuple[str, str]:
    return cell.solver, cell.profile
