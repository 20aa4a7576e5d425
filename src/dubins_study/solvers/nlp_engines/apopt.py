"""APOPT, an active-set SQP method, by gekko's program.

The APMonitor program that the package gekko brings is started as gekko starts it: in a folder of
its own, on a model and options in APMonitor's language. It writes ten digits of a point.
"""

from __future__ import annotations

import importlib.util
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from itertools import chain
from pathlib import Path as FilePath

import numpy as np

from dubins_study.solvers.nlp_engines.expressions import algebra_text
from dubins_study.solvers.nlp_engines.program import NlpCall, Program
from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.solvers.statuses import STATUSES, claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import Claim

_MODEL = "model"  # APMonitor's names of its files


def apopt(options: OptionValues) -> NlpCall:
    """A call of APOPT with the given options.

    Its RTOL is on the equations, its OTOL on the objective.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        chosen = {"solver": 1, "imode": 3, **program.attainable(options, "rtol")}
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
            folder = FilePath(name)
            (folder / f"{_MODEL}.apm").write_text(_model(program, guess))
            lines = [f"apm.{option} = {value}\n" for option, value in chosen.items()]
            (folder / f"{_MODEL}.dbs").write_text("".join(lines))
            log = _log(folder, seconds)
            x = _point(folder / "results.json", guess.size)
        if log is None:
            status = "time limit"
            claim = claim_of("apopt", status)
            return EngineResult(x, claim, status=status, message="stopped")
        # the status is the first listed one that was printed, or else the end of the output
        statuses = chain.from_iterable(STATUSES["apopt"].values())
        printed = (line for line in statuses if line in log)
        status = next(printed, log.strip()[-200:] or "no words")
        claim = claim_of("apopt", status)
        if claim is Claim.LOCAL and np.isnan(x).any():
            claim = Claim.FAILED
            status = "no results.json"
        message = status
        if "@error" in log:
            message = log[log.find("@error") :].strip()
        return EngineResult(x, claim, iterations=_iterations(log), status=status, message=message)

    return run


def unavailable() -> str | None:
    """The reason why the program cannot run, or None."""
    file = _program()
    if os.access(file, os.X_OK):
        return None
    return f"gekko's program {file.name} cannot be run on this machine"


def _program() -> FilePath:
    """The path of APMonitor's program for this machine.

    Gekko chooses among its programs in the same way.
    """
    spec = importlib.util.find_spec("gekko")
    assert spec is not None
    assert spec.origin is not None
    names = {"darwin": "apm_mac", "win32": "apm.exe"}
    arm = {"aarch64": "apm_aarch64", "arm64": "apm_aarch64", "armv7l": "apm_arm"}
    name = names.get(sys.platform) or arm.get(platform.machine(), "apm")
    return FilePath(spec.origin).parent / "bin" / name


def _model(program: Program, guess: FloatArray) -> str:
    """The program in APMonitor's language."""
    text = algebra_text(program)
    bounds = zip(guess.tolist(), program.lower.tolist(), program.upper.tolist(), strict=True)
    variables = [
        f"{name} = {value!r}{_bound('>=', lower)}{_bound('<=', upper)}"
        for name, (value, lower, upper) in zip(text.variables, bounds, strict=True)
    ]
    intermediates = [f"{name} = {expression}" for name, expression in text.intermediates]
    equations = [f"{side} = 0" for side in text.equations]
    sections = {
        "Variables": variables,
        "Intermediates": intermediates,
        "Equations": [*equations, f"minimize {text.objective}"],
    }
    lines = []
    for name, body in sections.items():
        lines += [name, *body, f"End {name}"]
    return "\n".join(("Model", *lines, "End Model", ""))


def _bound(sign: str, value: float) -> str:
    if math.isfinite(value):
        return f", {sign} {value!r}"
    return ""


def _log(folder: FilePath, seconds: float) -> str | None:
    """Run the program; return the text that it prints.

    None if it was stopped at its time limit.
    """
    before_start = None if sys.platform == "win32" else _lift_data_limit
    try:
        completed = subprocess.run(
            [_program(), _MODEL],
            cwd=folder,
            env={"PATH": str(folder)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=seconds,
            check=False,
            preexec_fn=before_start,
        )
    except subprocess.TimeoutExpired:
        return None
    return completed.stdout.decode(errors="replace") + f"\nexit code {completed.returncode}"


def _lift_data_limit() -> None:
    """Lift the process's limit of data memory.

    The program reserves gigabytes, of which it fills a few MB. Within a worker's limit it ends now
    and then with exit code 41, insufficient virtual memory.
    """
    import resource

    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (hard, hard))


def _point(file: FilePath, n: int) -> FloatArray:
    """The variables in a file of results, shape (n,).

    All are NaN if there is no file.
    """
    if not file.is_file():
        return np.full(n, math.nan)
    # each variable has a list of values, of which the last one is the result
    values = json.loads(file.read_text())
    return np.array([values[f"x[{i}]"][-1] for i in range(1, n + 1)], dtype=float)


def _iterations(log: str) -> int | None:
    """The last iteration number in the log, or None."""
    table = log.partition("Convergence")[2].splitlines()
    rows = [words for words in map(str.split, table) if len(words) == 3 and words[0].isdigit()]
    if not rows:
        return None
    return int(rows[-1][0])
