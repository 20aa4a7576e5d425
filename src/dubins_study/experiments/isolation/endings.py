"""What is said of a worker's end, in a row or in a refusal."""

from __future__ import annotations

import signal

from dubins_study.solvers.attempt import Reply, nothing
from dubins_study.solvers.protocol import Outcome


def ending(code: int | None) -> tuple[str, str]:
    """A worker's end in a word and in a sentence."""
    if code is None:
        return "unknown", "its process ended"
    if code >= 0:
        return f"exit {code}", f"its process ended itself with code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return name, f"its process was ended by {name}"


def crashed(code: int | None, words: str) -> Reply:
    """The reply of a worker that ended by itself, with its last words."""
    status, message = ending(code)
    said = f"{message}; its last words: {words}" if words else message
    # C++ ends a process so that may have no more memory
    starved = code == -signal.SIGABRT and "bad_alloc" in words
    return nothing(Outcome.OUT_OF_MEMORY if starved else Outcome.CRASHED, said, status=status)


def again(reply: Reply) -> Reply:
    """The same reply for another cell of a solver that cannot be loaded."""
    solution = reply.solution
    said = f"{solution.message} for another cell; not tried again"
    return nothing(reply.outcome, said, status=solution.native_status)
