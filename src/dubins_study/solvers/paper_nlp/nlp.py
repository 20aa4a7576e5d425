"""The paper's model by any NLP engine: those of `nlp_engines`, KNITRO, or one that AMPL calls.

An executable is looked up on PATH by its name and run as AMPL runs it (`solvers.paper_nlp.ampl`).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from dubins_study.solvers.nlp_engines import table
from dubins_study.solvers.nlp_engines.table import ENGINES
from dubins_study.solvers.paper_nlp import ampl, pyomo_direct
from dubins_study.solvers.paper_nlp.local_nlp import LocalNlp, Run
from dubins_study.solvers.paper_nlp.program import solve
from dubins_study.solvers.protocol import Method, Solver
from dubins_study.solvers.setting_checks import positive, within
from dubins_study.study.values import did_you_mean

# A path would let whoever writes an experiment choose the file that is run.
_EXECUTABLE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
_KNITRO = "knitro"
_DEFAULT = "trust-constr"
_LISTED_APART = (_DEFAULT, "slsqp", "ipopt")  # the last two as solvers of their own


@dataclass(frozen=True)
class _Named(Solver):
    """The setting that a canonical spec names before those of `LocalNlp`.

    Args:
        engine: a name in `nlp_engines.table.ENGINES`, `knitro`, or the name of an executable on
            PATH that reads NL files.
    """

    engine: str = _DEFAULT


@dataclass(frozen=True)
class Nlp(LocalNlp, _Named):
    """Model (4.12) by one of many NLP engines; settings not explained here: `LocalNlp`.

    Args:
        tol: the feasibility, and with most engines the optimality, that an engine of the table is
            asked for; KNITRO and executables run with their defaults, as in the paper.
        max_iter: largest number of iterations of an engine of the table.
    """

    tol: float = 1e-9
    max_iter: int = 200

    name: ClassVar[str] = "nlp"
    packages: ClassVar[tuple[str, ...]] = tuple(
        dict.fromkeys(
            (
                *(package for entry in ENGINES.values() for package in entry.packages),
                "pyomo",
                _KNITRO,
            )
        )
    )
    summary: ClassVar[str] = "the paper's model (4.12) by any NLP engine or AMPL solver"
    variants: ClassVar[tuple[str, ...]] = tuple(
        f"nlp[engine={engine}]" for engine in (*ENGINES, _KNITRO) if engine not in _LISTED_APART
    )
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        positive(max_iter=self.max_iter)
        within(tol=(self.tol, 1e-14, 1e-2))
        if not _EXECUTABLE.fullmatch(self.engine):
            raise ValueError(
                f"engine is {self.engine!r}; expected one of {', '.join(ENGINES)}, {_KNITRO}, or "
                "the name of an executable on PATH: letters, digits, '_', '.' and '-', no folders"
            )

    @property
    def method(self) -> Method:
        entry = ENGINES.get(self.engine)
        label = entry.label if entry else "KNITRO" if self.engine == _KNITRO else self.engine
        tol = table.tolerance(self.engine, self.tol) if entry else None
        return Method(self.formulation, label, self.initial_guess, tol)

    @property
    def runs(self) -> str | None:
        """The program on PATH that is started, if any."""
        return None if self.engine in ENGINES or self.engine == _KNITRO else self.engine

    def unavailable(self) -> str | None:
        if self.engine in ENGINES:
            return table.unavailable(self.engine)
        if self.engine == _KNITRO:
            return pyomo_direct.knitro_unavailable()
        missing = ampl.unavailable(self.engine)
        near = did_you_mean(self.engine, (*ENGINES, _KNITRO))
        engines = f"no engine of that name; {near}there are: {', '.join(ENGINES)}"
        return missing and f"{missing}, and {engines}"

    @property
    def keeps_limit(self) -> bool:
        if self.engine in ENGINES:
            return ENGINES[self.engine].keeps_limit
        # executables are killed at the limit; KNITRO was never tried with a licence
        return self.engine != _KNITRO

    def run(self) -> Run:
        if self.engine in ENGINES:
            engine = table.engine(self.engine, self.tol, self.max_iter)
            return partial(solve, engine=engine)
        if self.engine == _KNITRO:
            return partial(pyomo_direct.solve, interface="knitro_direct")
        return partial(ampl.solve, executable=self.engine)
