"""Descriptions of the solvers that an experiment names.

A description holds all that a run must know of a solver.

`*` names all of them, `{a,b}` several settings. Our own solvers are loaded in this process. A
plug-in (a file, or another package's entry point) is loaded in a separate process, because it may
hang, crash, or change its process.
"""

from __future__ import annotations

import sys
from contextlib import closing
from functools import cache
from typing import Any, NamedTuple

from pydantic_core import PydanticCustomError

from dubins_study.asking.reply import exception_text
from dubins_study.experiments.code_digest import code_digest, plain_settings
from dubins_study.experiments.definition.messages import SOLVER_ERROR
from dubins_study.experiments.isolation.messages import Channel
from dubins_study.experiments.isolation.worker import answer_tasks
from dubins_study.experiments.isolation.worker_process import (
    Allowance,
    Answered,
    Ended,
    WorkerProcess,
)
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.registry import (
    SolverError,
    canonical,
    load,
    ours,
    registered,
    stated_method,
    unavailable,
)
from dubins_study.study.specs import plugin_file, written_out

_LOADING = Allowance(60.0, activity="loading it")  # of the import of a plug-in
_ASKING = Allowance(10.0, activity="asking whether it can run")


class SolverDescription(NamedTuple):
    """A solver under a profile, in plain values.

    JSON can hold all of them, so that a plug-in's process can send them.
    """

    spec: str  # canonical, as in rows
    method: Method
    code_digest: str
    settings: dict[str, Any]
    packages: tuple[str, ...]
    warm: bool  # it uses an initial guess
    runs: str | None  # the program on PATH that it starts
    keeps_limit: bool  # its own class promises `Solver.keeps_limit`
    whole_frames: bool  # it answers whole frames at once


@cache
def describe_solver(spec: str, profile: str = "default") -> SolverDescription:
    """Describe the solver of a spec.

    A spec of no usable solver is refused, as by `solvers.registry.load`.
    """
    if ours(spec):
        return _describe(spec, profile)
    event = _ask_apart("description", spec, profile, _LOADING)
    if isinstance(event, Ended):
        raise SolverError(f"solver {spec!r}: while it was loaded, {event.reply.solution.message}")
    fields, message = event.value
    if message is not None:
        raise SolverError(str(message))
    packages = tuple(fields["packages"])
    method = Method(*fields["method"])
    return SolverDescription(**(fields | {"packages": packages, "method": method}))


def why_unavailable(spec: str, profile: str = "default") -> str | None:
    """Why a solver cannot run here, or None.

    None also stands for a plug-in that dies or hangs here: its rows will show that.
    """
    if ours(spec):
        return _availability(spec, profile)
    event = _ask_apart("availability", spec, profile, _ASKING)
    if isinstance(event, Ended):
        return None
    reason: str | None = event.value
    return reason


def _ask_apart(topic: str, spec: str, profile: str, allowance: Allowance) -> Answered | Ended:
    """Ask about a plug-in in a separate process.

    The process loads the plug-in. `topic` is "description" or "availability". Returns the answer,
    or the end of the process.
    """
    with closing(WorkerProcess(f"{__name__}:serve_plugin", [], sys.maxsize)) as worker:
        return worker.request([topic, spec, profile], allowance)


def _describe(spec: str, profile: str) -> SolverDescription:
    solver = load(spec, profile)
    # a plug-in inherits no promise: its changes of one of our solvers may break it
    promises = ours(spec) or "keeps_limit" in vars(type(solver))
    runs = solver.runs
    if runs is not None:
        runs = str(runs)
    return SolverDescription(
        spec=canonical(spec, profile),
        method=stated_method(solver),
        code_digest=code_digest(spec, profile),
        settings=plain_settings(solver),
        packages=tuple(str(package) for package in solver.packages),
        warm=bool(solver.warm),
        runs=runs,
        keeps_limit=bool(solver.keeps_limit) and promises,
        whole_frames=solver.solve_frame is not None,
    )


def serve_plugin(channel: Channel) -> None:
    """Answer questions about plug-ins.

    This runs in the process that loads them. A task is `[topic, spec, profile]`.
    """
    functions = {"description": _description, "availability": _availability}

    def answer(task: list[str]) -> tuple[Any, bool]:
        function, spec, profile = task
        return functions[function](spec, profile), False

    answer_tasks(channel, answer)


def _availability(spec: str, profile: str) -> str | None:
    """Why a solver cannot run here."""
    return unavailable(load(spec, profile))


def _description(spec: str, profile: str) -> list[Any]:
    """Fields of the description, and an error message.

    One of the two is None.
    """
    try:
        return [_describe(spec, profile)._asdict(), None]
    except SolverError as error:
        return [None, str(error)]
    except BaseException as error:  # a plug-in may raise anything
        return [None, f"solver {spec!r} cannot be described: {exception_text(error)}"]


def expand_solvers(specs: list[str], profile: str = "default") -> list[str]:
    """Canonical specs under a profile, without duplicates.

    `*` and `{a,b}` are expanded.
    """
    expanded: list[str] = []
    for spec in specs:
        names = written_out(spec)
        if spec == "*":
            names = registered()
        expanded += [describe_solver(name, profile).spec for name in names]
    return list(dict.fromkeys(expanded))


def check_spec(spec: str, profile: str, *, trust_plugins: bool) -> None:
    """Refuse a spec of a file if not usable.

    A solver that does not exist or cannot be described is refused. Unless `trust_plugins`, so is a
    plug-in file or a program on PATH, and it is not loaded: the experiment's file may come from
    anyone.
    """
    if spec == "*":
        return
    try:
        for name in written_out(spec):
            if not trust_plugins and _untrusted(name, profile):
                raise SolverError(f"{name} {_UNTRUSTED}")
            describe_solver(name, profile)
    except SolverError as error:
        raise PydanticCustomError(SOLVER_ERROR, "{text}", {"text": str(error)}) from None


_UNTRUSTED = (
    "runs a program or file that is not this package's; expected --trust-plugins, if you know what "
    "it is, or your own choice of --solver"
)


def _untrusted(spec: str, profile: str) -> bool:
    """Whether a spec runs a program or file.

    The file is a plug-in, the program is on PATH; the check runs neither.
    """
    return plugin_file(spec) is not None or (
        ours(spec) and describe_solver(spec, profile).runs is not None
    )
