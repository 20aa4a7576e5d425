"""A time at which the Ipopt library, between two iterations, stops with the point it has."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any


@dataclass
class Deadline:
    """When to stop (s, on `perf_counter`). It may be set anew before every run.

    It must live as long as the programs that it stops: casadi does not keep what it calls.
    """

    at: float = math.inf
    watches: list[Any] = field(default_factory=list)

    def watch(self, variables: int, rows: int) -> Any:
        """The function that casadi calls after every iteration of a program of this size.

        It costs some 0.1 ms an iteration; Ipopt's own time limits are fixed once compiled.
        """
        import casadi

        sizes = {"x": variables, "lam_x": variables, "g": rows, "lam_g": rows, "f": 1}

        class Watch(casadi.Callback):
            """Told of every iteration; answers whether to stop."""

            def __init__(self, deadline: Deadline) -> None:
                casadi.Callback.__init__(self)
                self.deadline = deadline
                self.construct("watch", {})

            def get_n_in(self) -> int:
                return int(casadi.nlpsol_n_out())

            def get_n_out(self) -> int:
                return 1

            def get_name_in(self, i: int) -> str:
                return str(casadi.nlpsol_out(i))

            def get_sparsity_in(self, i: int) -> Any:
                return casadi.Sparsity.dense(sizes.get(casadi.nlpsol_out(i), 0), 1)

            def eval(self, _: Any) -> list[int]:
                return [int(perf_counter() > self.deadline.at)]

        self.watches.append(Watch(self))
        return self.watches[-1]
