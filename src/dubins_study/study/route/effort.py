"""Limit how much a search may do.

The limits are a number of boxes, which is the same on every machine, and a number of seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter


class SpentError(Exception):
    """The effort is spent.

    The search ends with the result that it has.
    """


@dataclass
class Effort:
    """Limits of a search, and what it has spent.

    `spent` counts boxes that the search has bounded, and other work as boxes that take as long.
    """

    boxes: float = math.inf
    seconds: float = math.inf
    spent: int = 0
    began: float = field(default_factory=perf_counter)

    @property
    def late(self) -> bool:
        """Whether the seconds are over."""
        return perf_counter() - self.began > self.seconds

    def spend(self, boxes: int) -> bool:
        """Count some boxes, unless all is spent.

        Returns whether all is spent.
        """
        over = self.spent >= self.boxes or self.late
        if not over:
            self.spent += boxes
        return over

    def spend_or_end(self, boxes: float) -> None:
        """Count some boxes, or end the search.

        Raises:
            SpentError: if all is spent.
        """
        if self.spend(math.ceil(boxes)):
            raise SpentError

    def look_at_the_clock(self) -> None:
        """End the search if the seconds are over.

        Raises:
            SpentError: if they are.
        """
        if self.late:
            raise SpentError
