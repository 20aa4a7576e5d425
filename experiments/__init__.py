"""Experiments: what is asked of which solver, and the code that asks and records."""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    # lazily, so that the names of the experiments cost no import of every library
    if name == "run":
        from experiments.runner import run

        return run
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
