"""Optimisation solvers judged on a problem with an exact answer: the shortest Dubins path.

The whole public surface that a newcomer needs; everything is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dubins_study.experiments.run import run as run
    from dubins_study.report.page.render import render as render
    from dubins_study.solvers.attempt import solve as solve
    from dubins_study.solvers.frame import solve_frame as solve_frame
    from dubins_study.solvers.registry import available as available
    from dubins_study.study.path import Path as Path
    from dubins_study.study.scenario import Scenario as Scenario

_PUBLIC = {
    "Path": "study.path",
    "Scenario": "study.scenario",
    "available": "solvers.registry",
    "merge": "experiments.store.merge",
    "render": "report.page.render",
    "run": "experiments.run",
    "solve": "solvers.attempt",
    "solve_frame": "solvers.frame",
    "status": "experiments.store.status",
}
__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name in _PUBLIC:
        return getattr(import_module(f"dubins_study.{_PUBLIC[name]}"), name)
    if name == "__version__":
        from importlib.metadata import version

        return version("dubins-study")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_PUBLIC])
