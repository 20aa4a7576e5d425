"""The paper's model by any other NLP solver: SciPy's trust-constr, KNITRO, or one that AMPL calls.

An executable is looked up on PATH by its name and run as AMPL runs it (`solvers.paper_nlp.ampl`).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from dubins_study.solvers.paper_nlp import ampl, pyomo_direct
from dubins_study.solvers.paper_nlp.local_nlp import LocalNlp, Run
from dubins_study.solvers.paper_nlp.trust_constr import trust_constr
from dubins_study.solvers.protocol import Method, Solver
from dubins_study.solvers.setting_checks import positive, within

# A path would let whoever writes an experiment choose the file that is run.
_LABELS = {"trust-constr": "trust-constr", "knitro": "KNITRO"}
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class _Named(Solver):
    """The setting that a canonical spec names before those of `LocalNlp`."""

    engine: str = "trust-constr"


@dataclass(frozen=True)
class Nlp(LocalNlp, _Named):
    """Model (4.12) by one of several NLP solvers; settings not explained here: `LocalNlp`.

    `engine` is `trust-constr`, `knitro` or the name of an executable on PATH that reads NL files.
    `tol` and `max_iter` are for trust-constr (`solvers.paper_nlp.trust_constr`); the other solvers
    run with their defaults, as in the paper.
    """

    tol: float = 1e-9
    max_iter: int = 200

    name: ClassVar[str] = "nlp"
    packages: ClassVar[tuple[str, ...]] = ("scipy", "pyomo", "knitro")
    summary: ClassVar[str] = "the paper's model (4.12) by trust-constr, KNITRO or any AMPL solver"
    variants: ClassVar[tuple[str, ...]] = ("nlp[engine=knitro]",)
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        positive(max_iter=self.max_iter)
        within(tol=(self.tol, 1e-14, 1e-2))
        if not _NAME.fullmatch(self.engine):
            raise ValueError(
                f"engine is {self.engine!r}; expected trust-constr, knitro or the name of an "
                "executable on PATH: letters, digits, '_', '.' and '-', no folders"
            )

    @property
    def method(self) -> Method:
        return Method(
            self.formulation,
            _LABELS.get(self.engine, self.engine),
            self.initial_guess,
            self.tol if self.engine == "trust-constr" else None,
        )

    @property
    def runs(self) -> str | None:
        """The program on PATH that is started, if any."""
        return None if self.engine in ("trust-constr", "knitro") else self.engine

    def unavailable(self) -> str | None:
        if self.engine == "trust-constr":
            return None
        if self.engine == "knitro":
            return pyomo_direct.knitro_unavailable()
        return ampl.unavailable(self.engine)

    @property
    def keeps_limit(self) -> bool:
        # executables are killed at the limit; KNITRO was never tried with a licence
        return self.engine != "knitro"

    def run(self) -> Run:
        if self.engine == "trust-constr":
            return partial(trust_constr, tol=self.tol, max_iter=self.max_iter)
        if self.engine == "knitro":
            return partial(pyomo_direct.solve, interface="knitro_direct")
        return partial(ampl.solve, executable=self.engine)
