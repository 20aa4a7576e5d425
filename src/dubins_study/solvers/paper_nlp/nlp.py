"""The paper's model by any NLP engine, or by a solver that AMPL calls.

An executable is looked up on PATH by its name and run as AMPL runs it
(`paper_nlp.program.solve_by_ampl`).
"""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from dubins_study.solvers.engines import (
    APART,
    NLP_ENGINES,
    EngineSolver,
    names,
    packages,
)
from dubins_study.solvers.paper_nlp.local_nlp import Adapter, LocalNlp
from dubins_study.solvers.paper_nlp.program import solve, solve_by_ampl, solve_in_pyomo
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import iterations, option_set, tolerance
from dubins_study.study.values import did_you_mean
from dubins_study.study.words import NLP

# A path would let whoever writes an experiment choose the file that is run.
_EXECUTABLE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
_KNITRO = "knitro"
# The fastest engine that finds all 96 targets of benchmark-leg with the guesses of `bearing`.
_DEFAULT = "ipopt"
_ENGINES = names(NLP)


@dataclass(frozen=True)
class _Named(EngineSolver):
    """The setting that a canonical spec names before those of `LocalNlp`.

    Args:
        engine: a name in `solvers.engines` of the kind `local NLP`, or the name of an executable on
            PATH that reads NL files.
    """

    engine: str = _DEFAULT


@dataclass(frozen=True)
class Nlp(LocalNlp, _Named):
    """Model (4.12) by one of many NLP engines; settings not explained here: `LocalNlp`.

    Args:
        options: whose choice the options of an engine of the table are, `equal`, `default` or
            `tuned` (docs/engines.md); KNITRO and executables run with their defaults, as in the
            paper.
        tol: the feasibility, and with most engines the optimality, that is asked for; 0 for that of
            `options`.
        max_iter: largest number of iterations; 0 for that of `options`.
    """

    options: str = option_set()
    tol: float = tolerance()
    max_iter: int = iterations()

    name: ClassVar[str] = "nlp"
    always_named: ClassVar[tuple[str, ...]] = ("engine",)
    packages: ClassVar[tuple[str, ...]] = (*packages(NLP_ENGINES), "pyomo", _KNITRO)
    summary: ClassVar[str] = "the paper's model (4.12) by any NLP engine or AMPL solver"
    variants: ClassVar[tuple[str, ...]] = tuple(
        f"nlp[engine={engine}]" for engine in _ENGINES if engine not in APART
    )
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        if not _EXECUTABLE.fullmatch(self.engine):
            raise ValueError(
                f"engine is {self.engine!r}; expected one of {', '.join(_ENGINES)}, or "
                "the name of an executable on PATH: letters, digits, '_', '.' and '-', no folders"
            )

    @property
    def method(self) -> Method:
        if self.engine not in _ENGINES:
            return Method(self.formulation, self.engine, self.initial_guess)
        posed = self.formulation, self.initial_guess
        return self.library.method(*posed, self.options, self.tol)

    @property
    def runs(self) -> str | None:
        """The program on PATH that is started, if any."""
        return None if self.engine in _ENGINES else self.engine

    def unavailable(self) -> str | None:
        if self.engine in _ENGINES:
            return super().unavailable()
        if shutil.which(self.engine):  # whether it is a solver is seen when it is run
            return None
        engines = f"{did_you_mean(self.engine, _ENGINES)}there are: {', '.join(NLP_ENGINES)}"
        return f"no executable {self.engine!r} on PATH, and no engine of that name; {engines}"

    @property
    def keeps_limit(self) -> bool:
        # executables are killed at the limit; KNITRO was never tried with a licence
        return self.engine not in _ENGINES or self.library.keeps_limit

    def adapter(self) -> Adapter:
        if self.engine in NLP_ENGINES:
            call = self.library.load()(self.tol, self.max_iter, self.options)
            return partial(solve, engine=call)
        if self.engine == _KNITRO:
            return partial(solve_in_pyomo, interface="knitro_direct")
        return partial(solve_by_ampl, executable=self.engine)
