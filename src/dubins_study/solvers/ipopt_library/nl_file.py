"""A Pyomo model as casadi reads it from the NL file that Pyomo writes."""

from __future__ import annotations

import tempfile
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np


class Program(NamedTuple):
    """A Pyomo model with its variables in the caller's order (n of them) and the rows, equations
    with right-hand side 0, whose duals are wanted (m of them)."""

    model: Any
    variables: list[Any]
    rows: list[Any]


class NlFile(NamedTuple):
    """The contents of the file.

    Args:
        x, f, g: casadi's MX symbols and expressions, in the file's order.
        lower, upper: bounds of g.
        to_file: places of the caller's variables in the file's order, shape (n,).
        rows: places of the wanted rows in g.
    """

    x: Any
    f: Any
    g: Any
    lower: list[float]
    upper: list[float]
    to_file: Any
    rows: list[int]


def nl_file(program: Program) -> NlFile:
    """Write the model's NL file and read it."""
    import casadi
    from pyomo.repn.plugins.nl_writer import NLWriter

    with tempfile.TemporaryDirectory() as folder:
        file = FilePath(folder) / "model.nl"
        with file.open("w") as stream:
            # no presolve: every variable must keep its place, fixed or not
            info = NLWriter().write(program.model, stream, linear_presolve=False)
        builder = casadi.NlpBuilder()
        builder.import_nl(str(file))
    places = {id(variable): place for place, variable in enumerate(program.variables)}
    rows = {id(row): place for place, row in enumerate(info.constraints)}
    return NlFile(
        casadi.vertcat(*builder.x),
        builder.f,
        casadi.vertcat(*builder.g),
        builder.g_lb,
        builder.g_ub,
        np.array([places[id(variable)] for variable in info.variables]),
        [rows[id(row)] for row in program.rows],
    )
