"""Experiments: what is asked of which solver, and the code that asks and records."""

from __future__ import annotations

from typing import Any

_PUBLIC = {
    "merge": "experiments.union",
    "run": "experiments.runner",
    "status": "experiments.progress",
}


def __getattr__(name: str) -> Any:
    # lazily, so that the names of the experiments cost no import of every library
    from importlib import import_module

    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
