"""What a run must know of a solver, found without letting other people's code into the run.

Our own backends are loaded here. A plug-in, a file named on the command line or another package's
entry point, is loaded by a process of its own, which may hang, crash or change what it likes.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.exit_status import exit_status
from dubins_study.experiments.isolation.fork_server import fork
from dubins_study.experiments.isolation.messages import Channel, MessageError
from dubins_study.experiments.plan.code_digest import code, plain_settings
from dubins_study.experiments.provenance import versions_of
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.attempt import told
from dubins_study.solvers.registry import SolverError, canonical, load, ours

# for a plug-in to be imported, and for the kernel to end a process
_LOAD_LIMIT_S, _EXIT_WAIT_S = 60.0, 2.0


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
    fields = _described_apart(spec, profile)
    return Description(**(fields | {"packages": tuple(fields["packages"])}))


def _described_apart(spec: str, profile: str) -> dict[str, Any]:
    """A description's fields, found by a process of its own."""
    process = fork(f"{__name__}:send_description", [spec, profile])
    try:
        if not process.wait(_LOAD_LIMIT_S):
            raise SolverError(f"solver {spec!r} takes longer than {_LOAD_LIMIT_S:g} s to load")
        answer = next(process.channel.received(), None)
    except (EOFError, OSError, MessageError):
        answer = None
    finally:
        process.kill()
        process.wait(_EXIT_WAIT_S)
        code = process.exit_code()
        process.close()
    if answer is None:
        status = exit_status(code)[0]
        raise SolverError(f"solver {spec!r} ends the process that loads it: {status}")
    fields, error = answer[0]
    if error is not None:
        raise SolverError(str(error))
    return dict(fields)


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


def send_description(channel: Channel, spec: str, profile: str) -> None:
    """Send a description's fields or what is wrong with the solver, as plain values.

    Nothing of a plug-in's own classes may reach the process that asks.
    """
    try:
        channel.send([_describe(spec, profile)._asdict(), None])
    except SolverError as error:
        channel.send([None, str(error)])
    except BaseException as error:  # a plug-in may raise anything
        channel.send([None, f"solver {spec!r} cannot be described: {told(error)}"])
