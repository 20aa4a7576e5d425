"""SNOPT and MINOS as GAMS runs them, from the wheels that its Python package installs.

The demo licence in the wheels takes 1000 variables and equations, and expires five months after
their release.
"""

from __future__ import annotations

import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.expressions import Language, algebra_text
from dubins_study.solvers.nlp_engines.program import EngineResult, NlpCall, Program, no_point
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

# GAMS's model status, and what it claims; a local solver calls a linear problem's point optimal
_MODEL_STATUS = {
    1: ("optimal", Claim.LOCAL),
    2: ("locally optimal", Claim.LOCAL),
    4: ("infeasible", Claim.INFEASIBLE),
    5: ("locally infeasible", Claim.INFEASIBLE),
    7: ("feasible", Claim.FEASIBLE),
}
# GAMS's solver status, where it is not 1, a normal end
_SOLVER_STATUS = {
    2: ("iteration limit", Claim.LIMIT),
    3: ("time limit", Claim.LIMIT),
    4: ("stopped by the solver", Claim.FAILED),
    5: ("evaluation errors", Claim.FAILED),
    6: ("a function that the solver does not have", Claim.FAILED),
    7: ("no licence for a problem of this size", Claim.FAILED),
}

_LANGUAGE = Language("GAMS", "x{}", "power({}, {})", sys.maxsize)

_FEASIBILITY = ("major feasibility tolerance", "row tolerance")

_NO_LICENCE = 7  # GAMS's exit code
_START_S = 10.0  # for GAMS to start, which takes 20 ms

# what the listing of results has for a number that there is not
_NUMBERS = {"UNDF": math.nan, "NA": math.nan, "+INF": math.inf, "-INF": -math.inf, "EPS": 0.0}


def status(solver: int, model: int) -> tuple[str, Claim]:
    """What GAMS's two status numbers say, and claim."""
    if solver != 1:
        return _SOLVER_STATUS.get(solver, ("solver failure", Claim.FAILED))
    return _MODEL_STATUS.get(model, ("no solution", Claim.FAILED))


def unavailable() -> str | None:
    """Why GAMS cannot run here although its packages are installed, or None."""
    if sys.platform != "linux":
        return "GAMS's wheels are run on Linux only"
    code = _exit_code()
    if code == 0:
        return None
    licence = ": its demo licence is missing, invalid or expired" if code == _NO_LICENCE else ""
    return f"GAMS ends with exit code {code}{licence}"


@cache
def _exit_code() -> int | None:
    """How GAMS ends on a model without a solver; None if it does not end."""
    with _folder() as folder:
        (folder / "program.gms").write_text("scalar one / 1 /;\n")
        return _run(folder, _START_S)


def gams(options: dict[str, Any], solver: str) -> NlpCall:
    """A solver of GAMS, by its name in files of options."""

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        chosen = program.attainable(options, *(name for name in options if name in _FEASIBILITY))
        lines = [f"{option} {value!r}\n" for option, value in chosen.items()]
        with _folder(solver) as folder:
            (folder / "program.gms").write_text(_model(program, guess, solver))
            (folder / f"{solver}.opt").write_text("".join(lines))
            code = _run(folder, seconds)
            file = folder / "results.txt"
            words = file.read_text().split() if file.is_file() else []
        if code is None:
            return no_point(guess.size, Claim.LIMIT, "time limit", "stopped")
        if len(words) < 3 + guess.size:
            return no_point(guess.size, Claim.FAILED, f"exit code {code}", "no results")
        numbers = np.array([_NUMBERS.get(word) or float(word) for word in words])
        ending, model, iterations = (int(number) for number in numbers[:3])
        message, claim = status(ending, model)
        x, marginals = np.split(numbers[3:], [guess.size])
        native = f"solver status {ending}, model status {model}"
        return EngineResult(x, claim, -marginals, iterations, None, native, message)

    return run


def _model(program: Program, guess: FloatArray, solver: str) -> str:
    """The program in GAMS's language, which writes status numbers, iterations, x and marginals."""
    text = algebra_text(program, _LANGUAGE)
    rows = [f"e{i + 1}" for i in range(len(text.equations))]
    bounds = zip(guess.tolist(), program.lower.tolist(), program.upper.tolist(), strict=True)
    starts = [
        f"{name}.{field} = {value!r};"
        for name, values in zip(text.variables, bounds, strict=True)
        for field, value in zip(("l", "lo", "up"), values, strict=True)
        if math.isfinite(value)
    ]
    # GAMS takes a star in the first column for a comment, hence the space after the new line
    equations = [
        f"{row}.. {side} =e= 0;".replace(" ", "\n ")
        for row, side in zip(rows, text.equations, strict=True)
    ]
    wanted = ["program.solvestat", "program.modelstat", "program.iterusd"]
    wanted += [f"{name}.l" for name in text.variables] + [f"{row}.m" for row in rows]
    return "\n".join(
        (
            f"variables {', '.join(text.variables)}, length;",
            f"equations {', '.join(rows)}, objective;",
            *starts,
            *equations,
            f"objective.. length =e= {text.objective};".replace(" ", "\n "),
            f"model program / all /; option nlp = {solver};",
            "program.optfile = 1;",
            "solve program using nlp minimizing length;",
            "file results / 'results.txt' /; results.nr = 2; results.nd = 15; results.nw = 30;",
            "put results;",
            *(f"put {name} /;" for name in wanted),
            "",
        )
    )


@contextmanager
def _folder(*solvers: str) -> Iterator[FilePath]:
    """A folder to work in, and GAMS in a folder `system` in it, removed at the end."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        system = FilePath(name) / "system"
        system.mkdir()
        added = [import_module(f"gamspy_{solver}") for solver in solvers]
        for package in (import_module("gamspy_base"), *added):
            for file in FilePath(package.directory).iterdir():
                with suppress(FileExistsError):  # Python's own files, and no matter
                    (system / file.name).symlink_to(file)
        for changed in ("gams", "gmscmpun.txt"):  # GAMS looks for its files beside the first
            original = (system / changed).resolve()
            (system / changed).unlink()
            shutil.copy(original, system / changed)
        known, _, defaults = (system / "gmscmpun.txt").read_text().partition("DEFAULTS")
        entries = [known, *(f"{package.verbatim}\n\n" for package in added), "DEFAULTS", defaults]
        (system / "gmscmpun.txt").write_text("".join(entries))
        yield FilePath(name)


def _run(folder: FilePath, seconds: float) -> int | None:
    """GAMS's exit code on the model in a folder; None if it was stopped for its time."""
    system = folder / "system"
    command: list[str | FilePath] = [system / "gams", "program.gms", "lo=0"]
    environment = os.environ | {"LD_LIBRARY_PATH": str(system)}
    return exit_code(command, folder, seconds, environment)


def exit_code(
    command: Sequence[str | FilePath],
    folder: FilePath,
    seconds: float,
    environment: Mapping[str, str] | None = None,
) -> int | None:
    """The exit code of a program that works in the folder, reads and prints nothing.

    None if its time was up: it is killed, and its children too.
    """
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # so that its children can be ended with it
    )
    try:
        return process.wait(max(seconds, 0.0))
    except subprocess.TimeoutExpired:
        return None
    finally:
        with suppress(ProcessLookupError):  # it and its children may have ended already
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
