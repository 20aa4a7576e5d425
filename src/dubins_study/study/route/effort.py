"""How much a search may do: so many boxes, whatever the machine, and so many seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter


class SpentError(Exception):
    """The effort is spent; the search ends with what it has."""


@dataclass
class Effort:
    """What a search may spend, and has spent, in boxes that it bounds or work of their size."""

    boxes: float = math.inf
    seconds: float = math.inf
    spent: int = 0
    began: float = field(default_factory=perf_counter)

    @property
    def late(self) -> bool:
        """Whether the seconds are over."""
        return perf_counter() - self.began > self.seconds

    def spend(self, boxes: int) -> bool:
        """Count some more, unless all is spent; whether it is."""
        over = self.spent >= self.boxes or self.late
        self.spent += 0 if over else boxes
        return over

    def spend_or_end(self, boxes: float) -> None:
        """Count some more; raise `SpentError` if all is spent."""
        if self.spend(math.ceil(boxes)):
            raise SpentError

    def look_at_the_clock(self) -> None:
        """Raise `SpentError` if the seconds are over."""
        if self.late:
            raise SpentError
