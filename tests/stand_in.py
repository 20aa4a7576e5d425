"""A stand-in for an AMPL solver: reads an NL file, solves it with casadi's Ipopt, writes a .sol."""

from __future__ import annotations

import stat
import sys
from pathlib import Path

_PROGRAM = """#!{python}
import sys
import casadi
if "-v" in sys.argv:
    print("Ipopt 3.14.0 (stand-in)")
    sys.exit()
stub = next(a for a in sys.argv[1:] if not a.startswith("-") and "=" not in a)
stub = stub.removesuffix(".nl")
nl = casadi.NlpBuilder()
nl.import_nl(stub + ".nl")
nlp = dict(x=casadi.vertcat(*nl.x), f=nl.f, g=casadi.vertcat(*nl.g))
options = dict(print_level=0, sb="yes", bound_relax_factor=0)
solver = casadi.nlpsol("s", "ipopt", nlp, dict(print_time=False, ipopt=options))
found = solver(x0=nl.x_init, lbx=nl.x_lb, ubx=nl.x_ub, lbg=nl.g_lb, ubg=nl.g_ub)
x, y = found["x"].full().ravel(), -found["lam_g"].full().ravel()  # ASL's sign of duals
code = 0 if solver.stats()["success"] else 200
lines = ["", "Ipopt 3.14.0 (stand-in): " + solver.stats()["return_status"], "", "Options", "3",
         "1", "1", "0", str(len(y)), str(len(y)), str(len(x)), str(len(x))]
lines += [repr(float(v)) for v in (*y, *x)] + ["objno 0 " + str(code)]
open(stub + ".sol", "w").write("\\n".join(lines) + "\\n")
"""


def put_solver(folder: Path, name: str) -> None:
    """Put the stand-in into a folder, as an executable of this name."""
    put_program(folder, name, _PROGRAM.format(python=sys.executable))


def put_program(folder: Path, name: str, text: str) -> None:
    """Put any script into a folder, as an executable of this name."""
    file = folder / name
    file.write_text(text)
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
