"""Pontryagin's conditions of a route.

They are those of its legs, which its via points join. At a via point nu1 and nu2 may jump. nu3 does
not, nor H, which is zero on every leg. With nu0 = 1 all conditions on nu1 and nu2 of each leg and
on nu3 at its end are linear. Only the signs of nu3 on arcs are not, but they are linear for each
heading on an arc. A leg of three segments has one solution. A leg of fewer may have many, and its
neighbours choose among them. So the costates are those whose worst violation of all conditions is
least: a linear program (docs/derivation.md, section 9).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain, pairwise, takewhile
from operator import attrgetter
from time import perf_counter

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, hstack, vstack

from dubins_study.study.arrays import FloatArray, IntArray
from dubins_study.study.check.extremal import (
    Conditions,
    Extremal,
    conditions,
    largest,
    pieces,
)
from dubins_study.study.check.two_arcs import sign_margin
from dubins_study.study.check.visits import cut_out
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose

_BESIDE = 1e-5  # radii; a shorter piece between a via point and the end of a piece counts as none
_EXACT = 1e-10  # the least tolerance that HiGHS takes
_EXTREMAL = 1e-7  # a residual up to which nu3 may not jump
_TOLERANCES = ("primal_feasibility_tolerance", "dual_feasibility_tolerance")
_STOPPED = 1  # status of `linprog` at a limit
_CUTS = 20  # rounds of adding headings at which an arc has a sign condition


def route_extremal(
    path: Path, at: Sequence[float], radius: float, free: bool, until: float = math.inf
) -> Extremal | None:
    """Costates that fit a route best, with residuals.

    The costates are those of its last leg, the residuals of all legs. The path is one that can be
    driven, `at` has the arc lengths of its via points, and `free` says whether its final heading
    is. None where the conditions overflow, or where they are not solved by the time `until` of
    `perf_counter`.
    """
    legs = [leg for leg in route_legs(path, at, radius) if leg is not None]
    if len(legs) <= len(at):
        return None
    fit = _measure(legs, free, path.start.heading, jumps=(), until=until)
    jumps = _jumps(legs, free)
    if not jumps or (fit is not None and not fit.pmp_residual > _EXTREMAL):
        return fit
    other = _measure(legs, free, path.start.heading, jumps=jumps, until=until)
    extremals = [each for each in (fit, other) if each is not None]
    return min(extremals, key=attrgetter("pmp_residual"), default=None)


def _jumps(legs: Sequence[Conditions], free: bool) -> list[int]:
    """Legs before which nu3 may jump.

    A leg counts if only single arcs lie between its start and a given heading: the first one, or
    the final one. A single arc to a point on the turning circle of a given heading is shorter than
    all paths of other headings there by up to a turn. So that heading is as good as given.
    """
    arcs = [len(leg.hamiltonian) == len(leg.arcs) == 1 for leg in legs]
    jumps = list(takewhile(lambda i: arcs[i - 1], range(1, len(legs))))
    if not free:
        jumps += takewhile(lambda i: arcs[i], range(len(legs) - 1, 0, -1))
    return jumps


def _measure(
    legs: Sequence[Conditions], free: bool, heading: float, jumps: Sequence[int], until: float
) -> Extremal | None:
    """Costates of the last leg, with the worst residuals.

    The costates are in the world frame; the residuals are the worst of all legs. `heading` is the
    start's. `jumps` and `until` are as in `route_costates`; None where that has none.
    """
    fitted = route_costates(legs, free, jumps, until)
    if fitted is None:
        return None
    costates = [[1.0, *of_leg] for of_leg in fitted.tolist()]
    pairs = list(zip(costates, legs, strict=True))
    margin = min((sign_margin(nu, leg.arcs) for nu, leg in pairs if leg.arcs), default=0.0)
    equations, constants = _equations(legs, free, jumps)
    _, nu1, nu2, nu3 = costates[-1]
    c = math.cos(heading)
    s = math.sin(heading)
    transversality = None
    if free:
        transversality = abs(nu3) / legs[-1].stretch
    return Extremal(
        costate_x=nu1 * c - nu2 * s,
        costate_y=nu1 * s + nu2 * c,
        abnormal=False,
        hamiltonian=max(largest(leg.hamiltonian, nu) for nu, leg in pairs),
        sign_margin=margin,
        transversality=transversality,
        pmp_residual=max(float(np.abs(equations @ fitted.ravel() + constants).max()), -margin),
    )


def route_legs(path: Path, at: Sequence[float], radius: float) -> Iterator[Conditions | None]:
    """Conditions of each leg.

    Positions are seen from where the leg begins, in the frame of the path's start. None for a leg
    whose conditions overflow.
    """
    rate = path.curvatures * radius
    ends = np.concatenate(([0.0], np.cumsum(path.lengths))) / radius
    turned = 0.0
    cuts = np.array([0.0, *at, ends[-1] * radius]) / radius
    after = np.clip(np.searchsorted(ends, cuts), 1, rate.size)
    before = after - 1
    # a cut beside the end of a piece is moved there
    nearest = np.where(cuts - ends[before] <= ends[after] - cuts, ends[before], ends[after])
    cuts = np.where(np.abs(nearest - cuts) <= _BESIDE, nearest, cuts)
    for begin, end in pairwise(cuts.tolist()):
        part, lengths = cut_out(ends, begin, end)
        driven = lengths > 0.0
        rates = rate[part][driven]
        lengths = lengths[driven]
        leg_pieces = pieces(rates.tolist(), lengths.tolist())
        yield conditions(*leg_pieces, Pose(0.0, 0.0, turned))
        turned += float(rates @ lengths)


def route_costates(
    legs: Sequence[Conditions], free: bool, jumps: Sequence[int] = (), until: float = math.inf
) -> FloatArray | None:
    """Costates of each leg, shape (n, 3).

    The columns are nu1, nu2, and nu3 at the leg's end, in the frame of the path's start. nu3 may
    jump before the legs `jumps`. None if the linear programs cannot be solved, or are not by the
    time `until`.
    """
    equations, constants = _equations(legs, free, jumps)
    n = equations.shape[1]
    headings: list[tuple[int, float]] = []
    for i, leg in enumerate(legs):
        headings += [(i, heading) for heading in chain(*leg.arcs)]
    tolerances = dict.fromkeys(_TOLERANCES, _EXACT)
    for _ in range(_CUTS):
        seconds_left = until - perf_counter()
        if seconds_left <= 0.0:
            return None
        # variables: the costates, then the worst violation
        rows = vstack([equations, -equations, -_signs(headings, n)])
        solution = linprog(
            np.append(np.zeros(n), 1.0),
            hstack([rows, np.full((rows.shape[0], 1), -1.0)]),
            np.concatenate([-constants, constants, np.ones(len(headings))]),
            bounds=[(None, None)] * n + [(0.0, None)],
            options=tolerances | {"time_limit": seconds_left},
        )
        if solution.x is None or solution.status == _STOPPED:
            return None
        *costates, worst = solution.x
        fitted: FloatArray = np.reshape(costates, (-1, 3))
        # inside an arc the sign is worst where it passes the heading opposite to (nu1, nu2)
        more = [
            (i, math.atan2(-nu2, -nu1))
            for i, (leg, (nu1, nu2, nu3)) in enumerate(zip(legs, fitted.tolist(), strict=True))
            if sign_margin([1.0, nu1, nu2, nu3], leg.arcs) < -worst - 10 * _EXACT
        ]
        if not more:
            break
        headings += more
    return fitted


def _equations(
    legs: Sequence[Conditions], free: bool, jumps: Sequence[int]
) -> tuple[coo_array, FloatArray]:
    """Equations that hold on an extremal.

    A matrix times the costates, plus constants, is zero.
    """
    # leg, constant, factors: of nu3 at the end of the leg before, and of the leg's nu1, nu2, nu3
    rows: list[tuple[int, float, tuple[float, ...]]] = []
    for i, leg in enumerate(legs):
        rows += [(i, one, (0.0, *nu)) for one, *nu in (*leg.hamiltonian, *leg.straight)]
        if i > 0 and i not in jumps:  # nu3 is continuous
            rows.append((i, 0.0, tuple(c / leg.stretch for c in (-1.0, *leg.start[1:]))))
    if free:
        rows.append((len(legs) - 1, 0.0, (0.0, 0.0, 0.0, 1.0 / legs[-1].stretch)))
    # nu3 of the leg before stands just before the three numbers of a leg
    columns = np.array([3 * i for i, _, _ in rows])[:, None] + np.arange(-1, 3)
    constants = np.array([constant for _, constant, _ in rows])
    return _matrix([row for _, _, row in rows], columns, 3 * len(legs)), constants


def _signs(headings: Sequence[tuple[int, float]], n: int) -> coo_array:
    """Matrix of the sign conditions on arcs.

    On an extremal its product with the costates is at least -1: (nu1, nu2) along headings (rad) on
    arcs of legs.
    """
    rows = [(math.cos(heading), math.sin(heading)) for _, heading in headings]
    columns = np.array([3 * i for i, _ in headings], np.intp)[:, None] + np.arange(2)
    return _matrix(rows, columns, n)


def _matrix(rows: Sequence[tuple[float, ...]], columns: IntArray, n: int) -> coo_array:
    """Sparse matrix of n columns.

    `rows` has the numbers of each row, and `columns` where they stand, shape (rows, numbers).
    """
    numbers = np.array(rows, np.float64).reshape(columns.shape)
    # a column of -1 belongs to no leg; its number is 0 and may be added anywhere
    row_places = np.repeat(np.arange(len(rows)), columns.shape[1])
    places = row_places, np.maximum(columns, 0).ravel()
    return coo_array((numbers.ravel(), places), shape=(len(rows), n))
