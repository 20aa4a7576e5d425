"""What a run must know about a solver, without running other people's code in the run's process.

Our own solvers are loaded in this process. A plug-in, which is a file or another package's entry
point, is loaded in a process of its own: it may hang, crash, or change its process.
"""

from __future__ import annotations

import json
from concurrent.futures import TimeoutError
from functools import cache
from typing import Any, NamedTuple

from pebble import ProcessExpired
from pebble.concurrent import process

from dubins_study.experiments.isolation.endings import ending
from dubins_study.experiments.isolation.spawning import Context
from dubins_study.experiments.plan.code_digest import code_digest, plain_settings
from dubins_study.experiments.provenance import versions_of
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.attempt import told
from dubins_study.solvers.registry import SolverError, canonical, load, ours

_LOAD_LIMIT_S = 60.0


class SolverDescription(NamedTuple):
    """A solver under a profile.

    Args:
        spec: its canonical spec, as rows hold it.
        code_digest: see `code_digest.code_digest`.
        settings: its settings as values that JSON can hold.
        packages: the distributions that it uses.
        warm: whether it uses an initial guess.
        closed_form: whether it is our own closed form, which may answer whole frames of scenarios
            in the process of the run.
        runs: the name of the program on PATH that it starts, if any.
    """

    spec: str
    code_digest: str
    settings: dict[str, Any]
    packages: tuple[str, ...]
    warm: bool
    closed_form: bool
    runs: str | None

    @property
    def versions(self) -> dict[str, str]:
        """The versions of `packages`."""
        return versions_of(self.packages)


@cache
def describe_solver(spec: str, profile: str = "default") -> SolverDescription:
    """Describe the solver of a spec.

    Raises:
        SolverError: as `solvers.registry.load`, and if the process that loads a plug-in ends or
            takes longer than a minute.
    """
    if ours(spec):
        return _describe(spec, profile)
    describe_elsewhere = process(timeout=_LOAD_LIMIT_S, context=Context())(_describe_as_json)
    try:
        fields = json.loads(describe_elsewhere(spec, profile).result())
    except TimeoutError:
        raise SolverError(
            f"solver {spec!r} takes longer than {_LOAD_LIMIT_S:g} s to load"
        ) from None
    except ProcessExpired as error:
        how = ending(error.exitcode)[0]
        raise SolverError(f"solver {spec!r} ends the process that loads it: {how}") from None
    return SolverDescription(**(fields | {"packages": tuple(fields["packages"])}))


def _describe(spec: str, profile: str) -> SolverDescription:
    solver = load(spec, profile)
    return SolverDescription(
        canonical(spec, profile),
        code_digest(spec, profile),
        plain_settings(solver),
        tuple(str(package) for package in solver.packages),
        bool(solver.warm),
        type(solver) is Analytic,
        None if solver.runs is None else str(solver.runs),
    )


def _describe_as_json(spec: str, profile: str) -> str:
    """Describe a plug-in in the process that loads it.

    The description returns as JSON, so that the run unpickles no object of the plug-in's classes.
    """
    try:
        return json.dumps(_describe(spec, profile)._asdict())
    except SolverError as error:
        raise SolverError(str(error)) from None
    except BaseException as error:
        raise SolverError(f"solver {spec!r} cannot be described: {told(error)}") from None
