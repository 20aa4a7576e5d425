"""Why a process ended, in words, and the reply of a worker that did."""

from __future__ import annotations

import signal

from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.reply import Reply, no_answer


def exit_status(code: int) -> tuple[str, str]:
    """The end of a process in a word and in a sentence.

    Args:
        code: its exit code, or minus the number of the signal that ended it.
    """
    if code >= 0:
        return f"exit {code}", f"its process ended itself with code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return name, f"its process was ended by {name}"


def crashed(code: int, output: str) -> Reply:
    """The reply of a worker that ended by itself, with the last that it printed."""
    status, message = exit_status(code)
    if output:
        message = f"{message}; its last output: {output}"
    # C++ ends a process so that may have no more memory
    starved = code == -signal.SIGABRT and "bad_alloc" in output
    outcome = Outcome.OUT_OF_MEMORY if starved else Outcome.CRASHED
    return no_answer(outcome, message, status=status)
