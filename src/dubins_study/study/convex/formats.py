"""Write convex problems as QPS or CBF texts.

Other programs read these formats: QPS a QP, CBF a problem with cones or without. Each finite end of
a row is a row of its own, so that all numbers stay the same: none is a difference of two. Only in
CBF the diagonal of the quadratic term is rounded, since it becomes a cone with its square roots.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, vstack

from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex.problem import Problem, ProblemError

# rows of one kind: = b, <= b or >= b
_Part = tuple[str, csr_array, FloatArray]


def _one_sided(problem: Problem) -> list[_Part]:
    """Rows with one end each, in three parts.

    The parts are equations (E), rows with an upper end (L) and rows with a lower end (G), as QPS
    names them. A row with two ends is in two parts; an infinite end is left out.
    """
    ends = {"E": problem.u, "L": problem.u, "G": problem.l}
    masks = {"E": problem.equal, "L": ~problem.equal, "G": ~problem.equal}
    parts = []
    for kind, values in ends.items():
        rows = masks[kind] & np.isfinite(values)
        parts.append((kind, problem.A[rows], values[rows]))
    return parts


def qps_text(problem: Problem, name: str) -> str:
    """Text of a QP in a QPS file.

    It is MPS with a section QUADOBJ, in free format.

    Raises:
        ProblemError: if the problem has cones, which QPS does not support.
    """
    if problem.cones.size:
        raise ProblemError(f"{name} has cones, which QPS cannot say; expected a QP, or write CBF")
    kinds, rows, ends = zip(*_one_sided(problem), strict=True)
    A = coo_array(vstack(rows).tocsc())  # column by column
    b = np.concatenate(ends)
    lines = [f"NAME {name}", "ROWS", " N cost"]
    each = "".join(kind * values.size for kind, values in zip(kinds, ends, strict=True))
    lines += [f" {kind} r{row}" for row, kind in enumerate(each)]
    lines.append("COLUMNS")
    entries = [(column, "cost", value) for column, value in enumerate(problem.q.tolist())]
    entries += [(column, f"r{row}", value) for row, column, value in _numbered(A)]
    entries.sort(key=lambda entry: entry[0])  # a column's entries stand together
    lines += [f" x{column} {row} {value!r}" for column, row, value in entries]
    lines.append("RHS")
    lines += [f" rhs r{row} {value!r}" for row, value in enumerate(b.tolist())]
    lines.append("BOUNDS")
    for bound, values in (("LO", problem.lb), ("UP", problem.ub)):
        lines += [
            f" {bound} box x{column} {value!r}" for column, value in enumerate(values.tolist())
        ]
    lines.append("QUADOBJ")
    lines += [f" x{i} x{i} {value!r}" for i, value in enumerate(problem.p.tolist()) if value]
    return "\n".join([*lines, "ENDATA", ""])


def cbf_text(problem: Problem) -> str:
    """Text of a CBF file.

    It is the Conic Benchmark Format, version 3. If there is a quadratic term, a last variable v
    with 2 v >= sum p_i x_i^2 stands for it.
    """
    n = problem.q.size
    unit = eye_array(n, format="csr")
    bounds = [("L", unit, problem.ub), ("G", unit, problem.lb)]
    names = {"E": "L=", "L": "L-", "G": "L+"}
    parts = [(names[kind], A, -b) for kind, A, b in (*_one_sided(problem), *bounds)]
    for end, size in zip(np.cumsum(problem.cones), problem.cones, strict=True):
        cone = slice(end - size, end)
        parts.append(("Q", problem.C[cone], problem.d[cone]))
    cost = problem.q
    bent = np.flatnonzero(problem.p)
    # the cone 2 a b >= |c|^2 with a = v, b = 1 (the constant), and c_i = sqrt(p_i) x_i
    if bent.size:
        places = np.append(0, 2 + np.arange(bent.size)), np.append(n, bent)
        values = np.append(1.0, np.sqrt(problem.p[bent]))
        cone = csr_array((values, places), shape=(2 + bent.size, n + 1))
        parts = [(name, _wider(A), b) for name, A, b in parts]
        parts.append(("QR", cone, np.eye(1, 2 + bent.size, 1)[0]))
        cost = np.append(cost, 1.0)
    # parts without rows are left out; the last of a part's three values are its rows' ends
    parts = [part for part in parts if part[2].size]
    b = np.concatenate([ends for _, _, ends in parts])
    sections = {
        "VER": ["3"],
        "OBJSENSE": ["MIN"],
        "VAR": [f"{cost.size} 1", f"F {cost.size}"],
        "CON": [f"{b.size} {len(parts)}", *(f"{name} {ends.size}" for name, _, ends in parts)],
        "OBJACOORD": _coordinates(coo_array(cost)),
        "ACOORD": _coordinates(coo_array(vstack([rows for _, rows, _ in parts]))),
        "BCOORD": _coordinates(coo_array(b)),
    }
    return "\n".join("\n".join([name, *lines, ""]) for name, lines in sections.items())


def _wider(matrix: csr_array) -> csr_array:
    """Matrix with another column of zeros."""
    rows, columns = matrix.shape
    parts = matrix.data, matrix.indices, matrix.indptr
    return csr_array(parts, shape=(rows, columns + 1))


def _numbered(entries: Any) -> list[tuple[Any, ...]]:
    """Entries of a sparse array, as tuples.

    A tuple has the entry's place on each axis, then its value: (row, column, value) in a matrix.
    """
    parts = [*entries.coords, entries.data]
    return list(zip(*(part.tolist() for part in parts), strict=True))


def _coordinates(entries: Any) -> list[str]:
    """Lines of a sparse array's entries.

    The first line is their number, then one follows for each.
    """
    return [str(entries.nnz), *(" ".join(map(repr, entry)) for entry in _numbered(entries))]
