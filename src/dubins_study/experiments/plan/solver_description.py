"""What a run must know of a solver, found without letting other people's code into the run.

Our own backends are loaded here. A plug-in, a file named on the command line or another package's
entry point, is loaded by a process of its own, which may hang, crash or change what it likes.
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
from dubins_study.experiments.plan.code_digest import code, plain_settings
from dubins_study.experiments.provenance import versions_of
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.attempt import told
from dubins_study.solvers.registry import SolverError, canonical, load, ours

_PATIENCE = 60.0  # s for a plug-in to be imported


class Description(NamedTuple):
    """A solver under a profile.

    Args:
        spec: its canonical form, as rows write it.
        code: digest of its code, settings and libraries.
        settings: their values as JSON has them.
        packages: distributions that it rests on.
        warm: whether it has a use for a starting point.
        closed_form: whether it is our own closed form, which may answer whole frames in the run.
        runs: the program on PATH that it starts, if any.
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
        """Of its packages."""
        return versions_of(self.packages)


@cache
def described(spec: str, profile: str = "default") -> Description:
    """Describe the solver of a spec.

    Raises:
        SolverError: as `solvers.registry.load`, and if the process that loads a plug-in ends or
            takes longer than a minute.
    """
    if ours(spec):
        return _describe(spec, profile)
    elsewhere = process(timeout=_PATIENCE, context=Context())(_describe_apart)
    try:
        found = json.loads(elsewhere(spec, profile).result())
    except TimeoutError:
        raise SolverError(f"solver {spec!r} takes longer than {_PATIENCE:g} s to load") from None
    except ProcessExpired as error:
        how = ending(error.exitcode)[0]
        raise SolverError(f"solver {spec!r} ends the process that loads it: {how}") from None
    return Description(**(found | {"packages": tuple(found["packages"])}))


def _describe(spec: str, profile: str) -> Description:
    solver = load(spec, profile)
    return Description(
        canonical(spec, profile),
        code(spec, profile),
        plain_settings(solver),
        tuple(str(package) for package in solver.packages),
        bool(solver.warm),
        type(solver) is Analytic,
        None if solver.runs is None else str(solver.runs),
    )


def _describe_apart(spec: str, profile: str) -> str:
    """The same as JSON, where a plug-in may hold and raise what it likes: nothing of its own
    classes is to be unpickled in the run."""
    try:
        return json.dumps(_describe(spec, profile)._asdict())
    except SolverError as error:
        raise SolverError(str(error)) from None
    except BaseException as error:
        raise SolverError(f"solver {spec!r} cannot be described: {told(error)}") from None
