"""Optimisation solvers judged on a problem with an exact answer: the shortest Dubins path.

All public names are here. Each is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dubins_study.conformance.checks import check_solver as check_solver
    from dubins_study.errors import DubinsStudyError as DubinsStudyError
    from dubins_study.experiments.run import run as run
    from dubins_study.experiments.solve import solve as solve
    from dubins_study.experiments.solve import solve_frame as solve_frame
    from dubins_study.experiments.store.merge import merge as merge
    from dubins_study.experiments.store.status import status as status
    from dubins_study.missions.mission import Mission as Mission
    from dubins_study.missions.read import read_mission as read_mission
    from dubins_study.report.data.results import load_results as load_results
    from dubins_study.report.page.render import render as render
    from dubins_study.report.path_plot import plot_path as plot_path
    from dubins_study.report.two_runs.compare import compare as compare
    from dubins_study.solvers.protocol import Guarantee as Guarantee
    from dubins_study.solvers.protocol import Question as Question
    from dubins_study.solvers.protocol import Solution as Solution
    from dubins_study.solvers.protocol import Solver as Solver
    from dubins_study.solvers.registry import available_solvers as available_solvers
    from dubins_study.study.path import Path as Path
    from dubins_study.study.scenario import Scenario as Scenario
    from dubins_study.study.words import Claim as Claim
    from dubins_study.study.words import Verdict as Verdict

# the module that each public name is imported from
_MODULES = {
    "Claim": "study.words",
    "DubinsStudyError": "errors",
    "Guarantee": "solvers.protocol",
    "Mission": "missions.mission",
    "Path": "study.path",
    "Question": "solvers.protocol",
    "Scenario": "study.scenario",
    "Solution": "solvers.protocol",
    "Solver": "solvers.protocol",
    "Verdict": "study.words",
    "compare": "report.two_runs.compare",
    "available_solvers": "solvers.registry",
    "check_solver": "conformance.checks",
    "load_results": "report.data.results",
    "merge": "experiments.store.merge",
    "plot_path": "report.path_plot",
    "read_mission": "missions.read",
    "render": "report.page.render",
    "run": "experiments.run",
    "solve": "experiments.solve",
    "solve_frame": "experiments.solve",
    "status": "experiments.store.status",
}
__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return getattr(import_module(f"dubins_study.{_MODULES[name]}"), name)
    if name == "__version__":
        from importlib.metadata import version

        return version("dubins-study")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*_MODULES, "__version__"])
