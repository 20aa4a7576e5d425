"""Executables on PATH, run as AMPL runs them: a program as an NL file, its end from a .sol file."""

from __future__ import annotations

import math
import os
import shutil
import signal
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path as FilePath
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
from dubins_study.study.words import Claim

_STUB = "model"


def ampl_nlp(options: OptionValues, executable: str, names: Keywords) -> NlpCall:
    """An executable as a local engine."""

    def solve(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        asked = options | names.until(seconds)
        ended = _run(mixed_program(program), guess, executable, asked, seconds)
        if ended.x is None:
            return no_point(guess.size, ended.claim, ended.status, ended.message)
        return EngineResult(
            ended.x, ended.claim, ended.duals, status=ended.status, message=ended.message
        )

    return solve


def ampl_minlp(settings: Settings, executable: str, names: Keywords) -> MinlpCall:
    """An executable as an engine of mixed-integer programs, which tells no bound."""
    options: OptionValues = dict.fromkeys(names.options.feasibility, settings.feastol)
    if names.gap:
        options[names.gap] = settings.gap

    def solve(program: MixedProgram, seconds: float) -> ProvenResult:
        ended = _run(program, None, executable, options | names.until(seconds), seconds)
        return ProvenResult(
            ended.x, ended.claim, -math.inf, None, None, ended.status, ended.message
        )

    return solve


class _Ended(NamedTuple):
    """The end of a run; the duals are those of the rows, None where there are none."""

    claim: Claim
    status: str
    message: str
    x: FloatArray | None = None
    duals: FloatArray | None = None


def _run(
    program: MixedProgram,
    guess: FloatArray | None,
    executable: str,
    options: OptionValues,
    seconds: float,
) -> _Ended:
    """The end of `executable model -AMPL name=value ...`, from model.nl to model.sol.

    It runs in a folder of its own, with nothing on its input; at the limit it is ended with
    whatever it started. Nothing but the file that it leaves is read.
    """
    model = pyomo_model(program, guess)
    with tempfile.TemporaryDirectory() as name:
        folder = FilePath(name)
        written = nl_file(model)
        (folder / f"{_STUB}.nl").write_text(written.text, encoding="utf-8")
        code = _exit_code(executable, folder, options, seconds)
        file = folder / f"{_STUB}.sol"
        if code is None:
            return _Ended(Claim.LIMIT, "time limit", f"{executable} was stopped")
        if not file.is_file():
            lacking = f"{executable} wrote no .sol file; expected a solver that AMPL can call"
            return _Ended(Claim.FAILED, f"exit code {code}", lacking)
        text = file.read_text(encoding="utf-8", errors="replace")
    return _read(model, written, text, executable, code)


def _read(model: Any, written: NlFile, text: str, executable: str, code: int) -> _Ended:
    """What a .sol file says."""
    from io import StringIO

    from pyomo.common.errors import PyomoException
    from pyomo.contrib.solver.solvers.asl_sol_reader import (
        ASLSolFileSolutionLoader,
        parse_asl_sol_file,
    )

    try:
        solution = parse_asl_sol_file(StringIO(text))
    except (PyomoException, ValueError, LookupError, AssertionError) as error:
        message = f"{executable}'s .sol file: {type(error).__name__}: {error}"
        return _Ended(Claim.FAILED, f"exit code {code}", message)
    result = solution.solve_code
    claim = claim_of("ampl", str(result // 100))
    ended = _Ended(claim, f"solve_result_num {result}", " ".join(solution.message.split()))
    loader = ASLSolFileSolutionLoader(solution, written.info, model)
    variables, rows = list(model.x.values()), list(model.g.values())
    try:
        values = loader.get_vars(variables)
    except (PyomoException, AssertionError, LookupError):
        # each loader has its own way to say that there is no point, which some claims do not need
        pointless = claim if claim in (Claim.INFEASIBLE, Claim.LIMIT) else Claim.FAILED
        return ended._replace(claim=pointless)
    x = np.array([values[variable] for variable in variables])
    with suppress(PyomoException, NotImplementedError, LookupError):
        of_row = loader.get_duals(rows)
        # Pyomo's dual is the objective's change per unit of right-hand side, ours minus that
        ended = ended._replace(duals=-np.array([of_row[row] for row in rows]))
    return ended._replace(x=x)


def _exit_code(
    executable: str, folder: FilePath, options: OptionValues, seconds: float
) -> int | None:
    """The exit code of an executable, or None if it did not end in time."""
    path = shutil.which(executable)
    assert path is not None  # or the solver is unavailable
    process = subprocess.Popen(
        [
            *(FilePath(path).absolute(), _STUB, "-AMPL"),
            *(f"{name}={value}" for name, value in options.items()),
        ],
        cwd=folder,
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
