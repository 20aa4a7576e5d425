"""Optimisation solvers judged on a problem with an exact answer: the shortest Dubins path.

The whole public surface that a newcomer needs; everything is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from experiments.runner import run as run
    from report.page import render as render
    from solvers.answer import solve as solve
    from solvers.frame import solve_frame as solve_frame
    from solvers.registry import available as available
    from study.path import Path as Path
    from study.scenario import Scenario as Scenario

_PUBLIC = {
    "Path": "study",
    "Scenario": "study",
    "available": "solvers",
    "render": "report",
    "run": "experiments",
    "solve": "solvers",
    "solve_frame": "solvers",
}
__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), name)
    if name == "__version__":
        from importlib.metadata import version

        return version("dubins-study")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_PUBLIC])
