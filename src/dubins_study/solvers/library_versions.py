"""Versions of the libraries that lie inside other packages, asked of the libraries themselves."""

from __future__ import annotations

import ctypes
import re
import subprocess
from functools import cache
from pathlib import Path as FilePath

from dubins_study.solvers.protocol import Solver


def reported_versions(solver: Solver) -> dict[str, str]:
    """Versions of the libraries inside a solver's packages, as the solver reports them.

    Asked in the process that solves, since loading a library may take long or fail.
    """
    try:
        return {str(name): str(text) for name, text in dict(solver.library_versions()).items()}
    except Exception as error:  # a plug-in may fail in any way
        return {"library_versions": f"raised {type(error).__name__}"}


@cache
def ipopt_in_casadi() -> dict[str, str]:
    """The version of the Ipopt library that casadi's wheel carries."""
    import casadi

    # libipopt.so.3, libipopt.3.dylib or libipopt-3.dll
    libraries = sorted(FilePath(casadi.__file__).parent.glob("libipopt*3*"))
    numbers = tuple(ctypes.c_int() for _ in range(3))
    try:
        library = ctypes.CDLL(str(libraries[0]))
        library.GetIpoptVersion(*map(ctypes.byref, numbers))
    except (IndexError, OSError, AttributeError):
        return {"ipopt": "unknown"}
    return {"ipopt": ".".join(str(number.value) for number in numbers)}


@cache
def ipopt_executable() -> dict[str, str]:
    """The version of the executable `ipopt` on PATH, as it prints it."""
    try:
        process = subprocess.run(["ipopt", "-v"], capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError):
        return {"ipopt": "unknown"}
    match = re.search(r"\d+(?:\.\d+)+", process.stdout)
    return {"ipopt": match.group() if match else "unknown"}


@cache
def scip() -> dict[str, str]:
    """The version of the SCIP library inside pyscipopt."""
    from pyscipopt import Model

    model = Model()
    parts = (model.getMajorVersion(), model.getMinorVersion(), model.getTechVersion())
    return {"scip": ".".join(map(str, parts))}


def ipopt(executable: bool) -> dict[str, str]:
    """The version of the Ipopt that answers."""
    return ipopt_executable() if executable else ipopt_in_casadi()
