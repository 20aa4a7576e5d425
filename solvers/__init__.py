"""One file per backend, the promise they keep, and the call that puts a question to one."""

from __future__ import annotations

from typing import Any

_PUBLIC = {
    "Answer": "solvers.answer",
    "solve": "solvers.answer",
    "solve_frame": "solvers.frame",
    "available": "solvers.registry",
}


def __getattr__(name: str) -> Any:
    # lazily, so that importing one backend does not import pandas and the batch kernel
    from importlib import import_module

    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
