"""Executables on PATH, run as AMPL runs them.

A program is written as an NL file. Its end is read from a .sol file.
"""

from __future__ import annotations

import math
import os
import shutil
import signal
import subprocess
import tempfile
from contextlib import suppress
from io import StringIO
from pathlib import Path as FilePath
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.minlp_engines.mixed_program import (
    MinlpCall,
    MixedProgram,
    ProvenResult,
    Settings,
)
from dubins_study.solvers.nlp_engines.expressions import mixed_program
from dubins_study.solvers.nlp_engines.nl_file import NlFile, nl_file, pyomo_model
from dubins_study.solvers.nlp_engines.program import NlpCall, Program
from dubins_study.solvers.runs import EngineResult, no_point
from dubins_study.solvers.setting_checks import Keywords, OptionValues
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import DENIALS, Claim

_STUB = "model"


def ampl_nlp(options: OptionValues, executable: str, names: Keywords) -> NlpCall:
    """A call of an executable as a local engine."""

    def solve(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        run = _Run(executable, options, names, perf_counter() + seconds)
        return _ended(mixed_program(program), guess, run)

    return solve


def ampl_minlp(settings: Settings, executable: str, names: Keywords) -> MinlpCall:
    """A call of an executable on mixed-integer programs.

    The result has no bound, since a .sol file has none.
    """
    options: OptionValues = dict.fromkeys(names.options.feasibility, settings.feastol)
    if names.gap:
        options[names.gap] = settings.gap

    def solve(program: MixedProgram, seconds: float) -> ProvenResult:
        run = _Run(executable, options, names, perf_counter() + seconds)
        engine_result = _ended(program, None, run)
        point: FloatArray | None = engine_result.x
        if np.isnan(engine_result.x).any():
            point = None
        return ProvenResult(
            point,
            engine_result.claim,
            bound=-math.inf,
            nodes=None,
            iterations=None,
            status=engine_result.status,
            message=engine_result.message,
        )

    return solve


class _Run(NamedTuple):
    """An executable, its options, and the time limit.

    `until` is in s, on `perf_counter`. The time for writing the file counts as well.
    """

    executable: str
    options: OptionValues
    names: Keywords
    until: float


def _ended(program: MixedProgram, guess: FloatArray | None, run: _Run) -> EngineResult:
    """Run the executable on a program.

    The command is `executable model -AMPL name=value ...`. The executable reads model.nl and writes
    model.sol, in a folder of its own, with nothing on its input. At the limit it is ended together
    with every process that it started. Nothing but the .sol file is read. Without such a file the
    result has no point, and its message says why.
    """
    model = pyomo_model(program, guess)
    with tempfile.TemporaryDirectory() as name:
        folder = FilePath(name)
        written = nl_file(model)
        (folder / f"{_STUB}.nl").write_text(written.text, encoding="utf-8")
        code = _exit_code(run, folder)
        file = folder / f"{_STUB}.sol"
        if code is None:
            stopped = f"{run.executable} was stopped"
            return no_point(program.lower.size, Claim.LIMIT, "time limit", stopped)
        if not file.is_file():
            lacking = f"{run.executable} wrote no .sol file; expected a solver that AMPL can call"
            return no_point(program.lower.size, Claim.FAILED, f"exit code {code}", lacking)
        text = file.read_text(encoding="utf-8", errors="replace")
    return _read(model, written, text, run.executable)


def _read(model: Any, written: NlFile, text: str, executable: str) -> EngineResult:
    """The result in the text of a .sol file."""
    from pyomo.common.errors import PyomoException
    from pyomo.contrib.solver.solvers.asl_sol_reader import (
        ASLSolFileSolutionLoader,
        parse_asl_sol_file,
    )

    variables = list(model.x.values())
    rows = list(model.g.values())
    try:
        solution = parse_asl_sol_file(StringIO(text))
    except (PyomoException, ValueError, LookupError, AssertionError) as error:
        message = f"{executable}'s .sol file: {type(error).__name__}: {error}"
        return no_point(len(variables), Claim.FAILED, "unreadable .sol file", message)
    claim = claim_of("ampl", str(solution.solve_code // 100))
    status = f"solve_result_num {solution.solve_code}"
    message = " ".join(solution.message.split())
    loader = ASLSolFileSolutionLoader(solution, written.info, model)
    try:
        values = loader.get_vars(variables)
    except (PyomoException, AssertionError, LookupError):
        # each loader reports a missing point in its own way; some claims need no point
        if claim not in (*DENIALS, Claim.LIMIT):
            claim = Claim.FAILED
        return no_point(len(variables), claim, status, message)
    x = np.array([values[variable] for variable in variables])
    duals = None
    with suppress(PyomoException, NotImplementedError, LookupError):
        of_row = loader.get_duals(rows)
        # Pyomo's dual is d objective / d right-hand side; ours is its negative
        duals = -np.array([of_row[row] for row in rows])
    return EngineResult(x, claim, duals, status=status, message=message)


def _exit_code(run: _Run, folder: FilePath) -> int | None:
    """Run the executable; return its exit code.

    None if the executable did not end in time.
    """
    path = shutil.which(run.executable)
    assert path is not None  # or the solver is unavailable
    options = run.options | run.names.until(run.until - perf_counter())
    words = [f"{name}={value}" for name, value in options.items()]
    process = subprocess.Popen(
        [FilePath(path).absolute(), _STUB, "-AMPL", *words],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # so that its children can be ended with it
    )
    try:
        return process.wait(max(run.until - perf_counter(), 0.0))
    except subprocess.TimeoutExpired:
        return None
    finally:
        with suppress(ProcessLookupError):  # it and its children may have ended already
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
