"""Convex problems as files.

They are quadratic programs, and programs over second-order cones.

    minimise    1/2 sum_i p_i x_i^2 + q x
    subject to  l <= A x <= u,   lb <= x <= ub,   C x + d in Q_1 x Q_2 x ...

Q_i is the second-order cone of its size: the first number is at least the norm of the others. An
answer is the point x with multipliers y of the rows of A and z of the bounds, both positive where
an upper end pushes, and w in the cones; at an optimum p x + q + A' y + z = C' w.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cache, cached_property, lru_cache
from importlib.resources import files
from io import BytesIO
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from dubins_study.errors import DubinsStudyError
from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.scenario import Scenario
from dubins_study.study.values import did_you_mean

MATRICES = ("A", "C")
CSR = ("data", "indices", "indptr", "shape")
_FOLDER = files(__package__).joinpath("problems")


class ProblemError(DubinsStudyError, ValueError):
    """The file holds no convex problem.

    The message names the file.
    """


class Point(NamedTuple):
    """A primal and dual point.

    Shapes: x (n,), y (rows,), z (n,), w (rows of C,).
    """

    x: FloatArray
    y: FloatArray
    z: FloatArray
    w: FloatArray


@dataclass(frozen=True, eq=False)
class Problem:
    """A convex problem with n variables and m rows.

    All variables are bounded.

    Args:
        p: diagonal of the quadratic term, shape (n,), at least 0.
        q: linear term, shape (n,).
        A: rows, shape (m, n); `l` and `u` (m,) are their ends, infinite where there is none.
        lb, ub: finite bounds of the variables, shape (n,).
        C, d: matrix and constant of the points in the cones, shapes (k, n) and (k,).
        cones: sizes of the cones, shape (c,), which sum to k.
        interior: a point strictly inside all inequalities and cones, shape (n,).
        x, y, z, w: a primal and dual point whose proven interval is the reference
            (`study.convex.proof`).
    """

    p: FloatArray
    q: FloatArray
    A: csr_array
    l: FloatArray  # noqa: E741  the name that such files use
    u: FloatArray
    lb: FloatArray
    ub: FloatArray
    C: csr_array
    d: FloatArray
    cones: Any
    interior: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    w: FloatArray

    @property
    def witness(self) -> Point:
        """Primal and dual point that proves the reference.

        Its proven interval is the reference.
        """
        return Point(self.x, self.y, self.z, self.w)

    @cached_property
    def equal(self) -> BoolArray:
        """Mask of the rows that are equations.

        Shape (m,).
        """
        return np.equal(self.l, self.u)

    @property
    def numbers(self) -> int:
        """Count of numbers in a primal and dual point."""
        return int(2 * self.q.size + self.l.size + self.d.size)

    def split(self, numbers: FloatArray) -> Point:
        """Point from its numbers: x, y, z, then w."""
        m, n = self.A.shape
        return Point(*np.split(numbers, (n, n + m, 2 * n + m)))


def parse(content: bytes, name: str) -> Problem:
    """Problem of a file's bytes.

    Nothing is unpickled. A file without a convex problem is a `ProblemError`.
    """
    try:
        with np.load(BytesIO(content), allow_pickle=False) as stored:
            arrays: dict[str, Any] = dict(stored)
        for key in MATRICES:
            data, indices, indptr, shape = (arrays.pop(f"{key}_{part}") for part in CSR)
            arrays[key] = csr_array((data, indices, indptr), shape=tuple(shape))
        return Problem(**arrays)
    except (KeyError, TypeError, ValueError, OSError) as error:
        raise ProblemError(f"{name}: not a convex problem: {error}") from None


@cache
def listed() -> Mapping[str, Any]:
    """Packaged problems by name.

    Each has the SHA-256 of its file, and the route that it comes from.
    """
    entries = json.loads(_FOLDER.joinpath("list.json").read_text(encoding="utf-8"))
    return MappingProxyType(entries)


def matching(patterns: Iterable[str]) -> list[Scenario]:
    """Packaged problems whose names match a pattern.

    A pattern is like `qp-50-*`. Each problem is given as the route that it comes from, with its
    name as the label. The problem `trivial` has no route; floors are measured with it.
    """
    scenarios = []
    for name, entry in listed().items():
        if "route" in entry and any(fnmatchcase(name, pattern) for pattern in patterns):
            scenarios.append(Scenario(label=name, **entry["route"]))
    return scenarios


@lru_cache(maxsize=128)
def read(name: str) -> Problem:
    """Packaged problem of this name, one of `listed`.

    Raises:
        ProblemError: if there is none of this name, or its file was changed.
    """
    if name not in listed():
        near = did_you_mean(name, listed())
        raise ProblemError(
            f"no convex problem named {name!r}; {near}expected one such as qp-50-random-6-0"
        )
    content = _FOLDER.joinpath(f"{name}.npz").read_bytes()
    if hashlib.sha256(content).hexdigest() != listed()[name]["sha256"]:
        raise ProblemError(f"{name}.npz was changed: its SHA-256 is not that of {__package__}")
    return parse(content, name)


@lru_cache(maxsize=128)
def posed(name: str) -> Problem:
    """Problem without its answer, as engines get it.

    `interior`, x, y, z and w are empty arrays. Errors are those of `read`.
    """
    return replace(read(name), **dict.fromkeys(("interior", *Point._fields), np.zeros(0)))
