"""Convex problems as texts that other programs read: QPS (a QP) and CBF (a QP, or with cones).

Each finite end of a row is a row of its own, so that numbers stay as they are: none is a difference
of two. Numbers are written with 17 digits. In CBF the diagonal of the quadratic term is rounded: it
becomes a cone, with its square roots.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, vstack

from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex.problem import Problem, ProblemError


class Rows(NamedTuple):
    """Rows A x = b, A x <= b or A x >= b, by the kind."""

    kind: str  # E, L or G, as in QPS
    A: csr_array
    b: FloatArray


def one_sided(problem: Problem) -> tuple[Rows, Rows, Rows]:
    """The rows of a problem, each with one end."""
    upper = ~problem.equal & np.isfinite(problem.u)
    lower = ~problem.equal & np.isfinite(problem.l)
    return (
        Rows("E", problem.A[problem.equal], problem.u[problem.equal]),
        Rows("L", problem.A[upper], problem.u[upper]),
        Rows("G", problem.A[lower], problem.l[lower]),
    )


def qps_text(problem: Problem, name: str) -> str:
    """The text of a QPS file (MPS with a section QUADOBJ, in free format) of a QP.

    Raises:
        ProblemError: if the problem has cones, which QPS cannot say.
    """
    if problem.cones.size:
        raise ProblemError(f"{name} has cones, which QPS cannot say; expected a QP, or write CBF")
    rows = one_sided(problem)
    kinds = "".join(part.kind * part.b.size for part in rows)
    A = vstack([part.A for part in rows]).tocsc()
    b = np.concatenate([part.b for part in rows])
    lines = [f"NAME {name}", "ROWS", " N cost"]
    lines += [f" {kind} r{row}" for row, kind in enumerate(kinds)]
    lines.append("COLUMNS")
    for column, cost in enumerate(problem.q.tolist()):
        lines.append(f" x{column} cost {cost!r}")
        places = slice(*A.indptr[column : column + 2].tolist())
        entries = zip(A.indices[places].tolist(), A.data[places].tolist(), strict=True)
        lines += [f" x{column} r{row} {value!r}" for row, value in entries]
    lines.append("RHS")
    lines += [f" rhs r{row} {value!r}" for row, value in enumerate(b.tolist())]
    lines.append("BOUNDS")
    for column, (low, high) in enumerate(_pairs(problem.lb, problem.ub)):
        lines += [f" LO bnd x{column} {low!r}", f" UP bnd x{column} {high!r}"]
    lines.append("QUADOBJ")
    lines += [f" x{i} x{i} {value!r}" for i, value in enumerate(problem.p.tolist()) if value]
    return "\n".join([*lines, "ENDATA", ""])


def cbf_text(problem: Problem) -> str:
    """The text of a CBF file (Conic Benchmark Format, version 3).

    Where there is a quadratic term, a last variable v with 2 v >= sum p_i x_i^2 stands for it.
    """
    n = problem.q.size
    bent = np.flatnonzero(problem.p)
    unit = eye_array(n, format="csr")
    equal, upper, lower = one_sided(problem)
    parts = [
        ("L=", equal.A, -equal.b),
        ("L-", vstack([upper.A, unit]), -np.concatenate((upper.b, problem.ub))),
        ("L+", vstack([lower.A, unit]), -np.concatenate((lower.b, problem.lb))),
    ]
    ends = np.cumsum(problem.cones)
    for end, size in zip(ends.tolist(), problem.cones.tolist(), strict=True):
        parts.append(("Q", problem.C[end - size : end], problem.d[end - size : end]))
    cost = problem.q
    if bent.size:
        cost = np.append(cost, 1.0)
        roots = coo_array(
            (np.sqrt(problem.p[bent]), (2 + np.arange(bent.size), bent)), (2 + bent.size, n)
        )
        parts.append(("QR", roots, np.eye(1, 2 + bent.size, 1)[0]))
    parts = [part for part in parts if part[2].size]
    A = coo_array(vstack([rows for _, rows, _ in parts]))
    entries = [*_pairs(A.row, A.col, A.data)]
    if bent.size:
        entries.append((A.shape[0] - 2 - bent.size, n, 1.0))
    b = np.concatenate([ends for _, _, ends in parts])
    lines = ["VER", "3", "", "OBJSENSE", "MIN", ""]
    lines += ["VAR", f"{cost.size} 1", f"F {cost.size}", ""]
    lines += ["CON", f"{b.size} {len(parts)}"]
    lines += [f"{cone} {ends.size}" for cone, _, ends in parts]
    lines += _coordinates("OBJACOORD", _some(cost))
    lines += _coordinates("ACOORD", entries)
    lines += _coordinates("BCOORD", _some(b))
    return "\n".join([*lines, ""])


def _pairs(*arrays: Any) -> Iterator[tuple[Any, ...]]:
    return zip(*(array.tolist() for array in arrays), strict=True)


def _some(values: FloatArray) -> list[tuple[Any, ...]]:
    places = np.flatnonzero(values)
    return list(_pairs(places, values[places]))


def _coordinates(section: str, entries: list[tuple[Any, ...]]) -> Iterable[str]:
    """A section with a line an entry: its places, and its value."""
    lines = (" ".join(map(repr, entry)) for entry in entries)
    return chain(("", section, str(len(entries))), lines)
