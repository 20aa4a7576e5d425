"""How much a search may do: so many boxes, whatever the machine, and so many seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter


@dataclass
class Effort:
    """What a search may spend, and has spent, in boxes that it bounds or work of their size."""

    boxes: float = math.inf
    seconds: float = math.inf
    spent: int = 0
    began: float = field(default_factory=perf_counter)

    def spend(self, boxes: int) -> bool:
        """Count some more, unless all is spent; whether it is."""
        over = self.spent >= self.boxes or perf_counter() - self.began > self.seconds
        self.spent += 0 if over else boxes
        return over
