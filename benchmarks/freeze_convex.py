"""Make the frozen problems of the convex engines.

They are those of `turn-rate-qp` along 50 routes, and two families.

Three families, each of three sizes; docs/convex.md has the mathematics:

    qp    a QP of a sequence: each leg ends in a box around its point
    tube  the same step with Euclidean radii: legs end in discs, and so do their quarters
    time  the fastest drive along the path of a sequence (Verscheure et al. 2009, "Time-optimal path
          tracking for robots: a convex optimization approach", IEEE Trans. Autom. Control 54)

No problem has a penalty. Every row counts in units of its own limit: turn rates in 1 / radius,
positions in the mean leg's length, the cost in the path's length.
`python -m benchmarks.freeze_convex` writes the files anew.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_array, csr_array, diags_array, eye_array, kron, vstack

from dubins_study.solvers.arcs import Rollout
from dubins_study.solvers.convex.adapters import Ask, prepare
from dubins_study.solvers.optimal_control.turn_rate_qp import Sequence as QpSequence
from dubins_study.solvers.optimal_control.turn_rate_qp import TurnRateQp
from dubins_study.solvers.optimal_control.turn_rate_template import Numbers, QpTemplate
from dubins_study.solvers.protocol import Question
from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex import problem
from dubins_study.study.convex.problem import CSR, MATRICES, Point, Problem, ProblemError
from dubins_study.study.convex.proof import lower_bound, upper_bound
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim

LEGS = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 15, 20)
# size -> problems of each family
WANTED = {
    50: {"qp": 24, "tube": 8, "time": 8},
    500: {"qp": 24, "tube": 8, "time": 8},
    5000: {"qp": 12, "tube": 4, "time": 4},
}
_LEAST_STEPS, _MOST_STEPS = 5, 2000  # of a leg
# sequences are entered at one of six QPs, then at every twelfth
_BEGINNINGS = 6
_EVERY = 12
_MARGINS = (1e-5, 1e-6, 1e-7)  # by which all holds at the interior, the first that can be
_PART = 0.8  # of the trust region, which the nearest step may use (Nocedal and Wright, sec. 18.5)
_EASE = 1.25  # boxes and discs are a quarter larger than the nearest step needs
_LEAST_WIDTH = 1e-3  # mean legs
_TOP = 9.0  # largest squared speed; 1 where the path turns by the radius
_FASTER, _SLOWER = 0.5, 1.0  # accelerations; 1 is the largest to the side
_BEGIN = 0.01  # squared speed at both ends

Points = list[tuple[float, float]]


def routes() -> dict[str, Scenario]:
    """50 routes from (0, 0, 0), by name.

    A name has the layout and the number of legs. Lengths are in radii.
    """
    named = {}
    for legs in LEGS:
        random = np.random.default_rng([2026, legs])
        named[f"random-{legs}"] = _random(random, legs)
        named[f"tour-{legs}"] = _nearest_first(4 * math.sqrt(legs) * random.random((legs, 2)))
        centres = 12 * math.sqrt(legs) * random.random(((legs + 3) // 4, 2))
        points = centres[np.arange(legs) % len(centres)] + random.normal(size=(legs, 2))
        named[f"cluster-{legs}"] = _nearest_first(points)
        named[f"survey-{legs}"] = _rows(legs)
    del named["tour-1"], named["cluster-1"]  # one point is as random as another
    return {name: _scenario(points) for name, points in named.items()}


def _random(random: np.random.Generator, legs: int) -> Points:
    lengths = random.uniform(2, 8, legs)
    bearings = random.uniform(-math.pi, math.pi, legs)
    steps = lengths[:, None] * np.column_stack((np.cos(bearings), np.sin(bearings)))
    return list(map(tuple, np.cumsum(steps, axis=0).tolist()))


def _nearest_first(points: FloatArray) -> Points:
    """Order by the nearest point that is left.

    It is a tour's usual first guess.
    """
    left = list(map(tuple, points.tolist()))
    here: tuple[float, float] = (0.0, 0.0)
    order = []
    while left:
        here = min(left, key=lambda point: math.dist(point, here))
        left.remove(here)
        order.append(here)
    return order


def _rows(legs: int) -> Points:
    """Rows of a survey, driven to and fro.

    They are 12 radii long and 2.5 apart.
    """
    ends = [(2.0, 14.0), (14.0, 2.0)]
    return [(ends[k // 2 % 2][k % 2], 2.5 * (k // 2)) for k in range(legs)]


def _scenario(points: Points) -> Scenario:
    *via, (x, y) = [(round(x, 3), round(y, 3)) for x, y in points]
    return Scenario(via=via, target_x=x, target_y=y)


class Step(NamedTuple):
    """A QP that `turn-rate-qp` solves.

    It has its numbers, and what they were taken from.
    """

    numbers: Numbers
    rolled: Rollout
    scale: float  # the mean leg, radii


def sequence(route: Scenario, n: int) -> tuple[list[Step], Path | None]:
    """All QPs of one route, and the path.

    `turn-rate-qp` solves them with n steps a leg.
    """
    steps: list[Step] = []
    running: list[QpSequence] = []
    ask = QpSequence._ask
    solve = QpTemplate.solve

    def noted(self: QpSequence) -> Any:
        running[:] = [self]
        return ask(self)

    def recorded(self: QpTemplate, numbers: Numbers, *others: Any) -> Any:
        steps.append(Step(numbers, running[0].rolled, running[0].scale))
        return solve(self, numbers, *others)

    solver = TurnRateQp(n=n, initial_guess="one")
    model = solver.build(Question(route))
    with patch.object(QpSequence, "_ask", noted), patch.object(QpTemplate, "solve", recorded):
        return steps, solver.solve(model, limit=300.0).path


def positions(step: Step, parts: FloatArray) -> csr_array:
    """Moves of points of the legs.

    Rows are x and y in turn, in mean legs; columns are z, then t. A point is the end of so many
    steps of its leg; `parts` has their numbers.
    """
    legs = step.numbers.w.size
    N = step.numbers.c.size
    n = N // legs
    until = (np.arange(n) < np.array(parts)[:, None]).astype(float)
    added = kron(eye_array(legs), until)  # adds up a leg's first steps
    by_leg = kron(eye_array(legs), np.ones((n, 1)))
    blocks = []
    rolled = step.rolled
    for after, before, chord in zip(rolled.by_after, rolled.by_before, rolled.chords, strict=True):
        by_heading = diags_array([after, before[1:]], offsets=[0, -1], shape=(N, N))
        blocks.append([added @ by_heading, added @ diags_array(chord) @ by_leg])
    both = csr_array(block_array(blocks)) / step.scale
    points = legs * len(parts)
    return both[np.arange(2 * points).reshape(2, -1).T.ravel()]


def rates(step: Step) -> tuple[csr_array, FloatArray]:
    """Rows of the turn rates, and their upper ends.

    Columns are z and t. Rates are within 1 / radius, in that unit.
    """
    numbers = step.numbers
    N = numbers.c.size
    legs = numbers.w.size
    turn = diags_array([1 / numbers.upper, -1 / numbers.upper[1:]], offsets=[0, -1], shape=(N, N))
    stretched = kron(eye_array(legs), np.ones((N // legs, 1)))
    rows = block_array([[turn, -stretched], [-turn, -stretched]])
    ends = np.concatenate((numbers.above / numbers.upper, numbers.below / numbers.upper))
    return csr_array(rows), ends


def nearest(step: Step, ends: csr_array, missing: FloatArray) -> tuple[FloatArray, float]:
    """The best step in the trust region.

    The step (z, t) has the least largest miss in a part of the region. That miss comes with it.
    """
    A, high = rates(step)
    ones = np.ones((missing.size, 1))
    rows = block_array([[A, None], [ends, -ones], [-ends, -ones]])
    box = _PART * trust(step)
    bounds = [*zip(-box, box, strict=True), (0, None)]
    cost = np.append(np.zeros(box.size), 1.0)
    optimum = linprog(cost, rows, np.concatenate((high, missing, -missing)), bounds=bounds)
    return optimum.x[:-1], float(optimum.fun)


def trust(step: Step) -> FloatArray:
    """The largest changes of headings and lengths."""
    numbers = step.numbers
    reach = numbers.reach[0]
    stretch = numbers.stretch[0]
    return np.repeat((reach, stretch), (numbers.c.size, numbers.w.size))


def box_qp(step: Step) -> Problem:
    """The QP of a step.

    Its legs end in boxes around their points.
    """
    N = step.numbers.c.size
    legs = step.numbers.w.size
    ends = positions(step, [N // legs])
    missing = step.numbers.r.T.ravel()
    _, miss = nearest(step, ends, missing)
    width = max(_EASE * miss, _LEAST_WIDTH)
    return _step_problem(step, ends, missing, np.full(2 * legs, width), [])


def tube(step: Step) -> Problem:
    """The SOCP of a step.

    Its legs end in discs around the points, and so do the quarters of the present legs. Each leg's
    changes of headings lie in a ball, too.
    """
    N = step.numbers.c.size
    legs = step.numbers.w.size
    n = N // legs
    parts = [n // 4, n // 2, 3 * n // 4, n]
    missing = np.zeros((legs, 4, 2))
    missing[:, 3] = step.numbers.r.T
    of_parts = positions(step, parts)
    near, miss = nearest(step, positions(step, [n]), missing[:, 3].ravel())
    moved = np.hypot(*(of_parts @ near).reshape(-1, 2).T).reshape(legs, 4)
    moved[:, 3] = math.sqrt(2) * miss
    radius = np.maximum(_EASE * moved, _LEAST_WIDTH).ravel()
    bent = np.linalg.norm(near[:N].reshape(legs, n), axis=1)
    balls = np.maximum(_EASE * bent, 0.1 * step.numbers.reach[0] * math.sqrt(n))
    first = N + legs
    cones = [(r, np.arange(first + 2 * k, first + 2 * k + 2)) for k, r in enumerate(radius)]
    cones += [(r, np.arange(k * n, k * n + n)) for k, r in enumerate(balls)]
    return _step_problem(step, of_parts, missing.ravel(), np.repeat(radius, 2), cones)


def _step_problem(
    step: Step, moves: csr_array, missing: FloatArray, width: FloatArray, balls: Sequence[Any]
) -> Problem:
    """Length and curvature over z, t and s.

    s are the points' places off their centres.
    """
    numbers = step.numbers
    N = numbers.c.size
    legs = numbers.w.size
    k = width.size
    A, high = rates(step)
    box = np.concatenate((trust(step), width))
    sizes = np.array([1 + columns.size for _, columns in balls], dtype=int)
    heads = np.cumsum(sizes) - sizes
    d = np.zeros(sizes.sum())
    d[heads] = [radius for radius, _ in balls]
    others = np.delete(np.arange(d.size), heads)
    columns = np.concatenate([np.zeros(0, dtype=int), *(columns for _, columns in balls)])
    C = csr_array((np.ones(others.size), (others, columns)), shape=(d.size, box.size))
    return Problem(
        p=np.concatenate((numbers.c / legs, np.zeros(legs + k))),
        q=np.concatenate((np.zeros(N), numbers.w / legs, np.zeros(k))),
        A=_sorted(block_array([[A, None], [moves, -eye_array(k)]])),
        l=np.concatenate((np.full(2 * N, -np.inf), missing)),
        u=np.concatenate((high, missing)),
        lb=-box,
        ub=box,
        C=_sorted(C),
        d=d,
        cones=sizes,
        **dict.fromkeys(("interior", *Point._fields), np.zeros(0)),
    )


def fastest(path: Path) -> Problem:
    """The fastest drive along a path.

    Variables are squared speeds b, their roots c, 1 / speeds d, and accelerations.

    Between the N + 1 ends of the steps b is linear. Each speed is in units of that at which a turn
    by the radius takes the largest acceleration to the side; the cost is the time over that of this
    speed.
    """
    some = path.lengths > 1e-9
    length = path.lengths[some]
    bend = np.abs(path.curvatures[some])
    N = length.size
    sharp = np.maximum(np.append(bend, 0.0), np.append(0.0, bend))
    top = np.minimum(_TOP, 1 / np.maximum(sharp, 1 / _TOP))
    top[[0, -1]] = _BEGIN
    ones, none = np.ones(N), np.zeros(N + 1)
    rise = diags_array([-ones, ones], offsets=[0, 1], shape=(N, N + 1))
    both = diags_array([ones, ones], offsets=[0, 1], shape=(N, N + 1))
    A = block_array([[diags_array(0.5 / length) @ rise, csr_array((N, 2 * N + 1)), -eye_array(N)]])
    unit = eye_array(N + 1)
    each = eye_array(N)
    no_b, no_d = csr_array((N, N + 1)), csr_array((N + 1, N))
    C = block_array(
        [
            [unit, None, None, no_d],  # |(2 c, b - 1)| <= b + 1: c <= sqrt(b)
            [None, 2 * unit, None, None],
            [unit, None, None, None],
            [no_b, both, each, csr_array((N, N))],  # |(2, c + c' - d)| <= c + c' + d
            [no_b, None, None, None],
            [None, both, -each, None],
        ]
    )
    d = np.concatenate((none + 1, none, none - 1, 0 * ones, 2 * ones, 0 * ones))
    of_roots = np.arange(3 * N + 3).reshape(3, -1).T.ravel()
    of_inverses = 3 * N + 3 + np.arange(3 * N).reshape(3, -1).T.ravel()
    rows = np.concatenate((of_roots, of_inverses))
    slow = 1 / (2 * math.sqrt(_BEGIN))
    return Problem(
        p=np.zeros(4 * N + 2),
        q=np.concatenate((none, none, 2 * length / length.sum(), 0 * ones)),
        A=_sorted(A),
        l=0 * ones,
        u=0 * ones,
        lb=np.concatenate((none, none, 0 * ones, np.full(N, -_SLOWER))),
        ub=np.concatenate((top, np.sqrt(top), np.full(N, 2 * slow), np.full(N, _FASTER))),
        C=_sorted(csr_array(C)[rows]),
        d=d[rows],
        cones=np.full(2 * N + 1, 3),
        **dict.fromkeys(("interior", *Point._fields), np.zeros(0)),
    )


def _sorted(matrix: Any) -> csr_array:
    result = csr_array(matrix)
    result.sum_duplicates()
    result.eliminate_zeros()
    result.indices, result.indptr = result.indices.astype(np.int32), result.indptr.astype(np.int32)
    return result


def best_drive(bare: Problem) -> Point:
    """The solution of `fastest`.

    At each place it has the largest speed that both ends allow.
    """
    N = bare.l.size
    top = bare.ub[: N + 1]
    cost = bare.q[2 * N + 2 : 3 * N + 2]
    lengths = 0.5 / bare.A.data.reshape(N, 3)[:, 1]
    b = top.copy()
    for k in range(N):
        b[k + 1] = min(b[k + 1], b[k] + 2 * lengths[k] * _FASTER)
    for k in reversed(range(N)):
        b[k] = min(b[k], b[k + 1] + 2 * lengths[k] * _SLOWER)
    c = np.sqrt(b)
    both = c[:-1] + c[1:]
    inverse = 1 / both
    along = cost / (2 * both)  # the multipliers of the cones lie on their boundaries
    pull = (np.append(along * inverse, 0.0) + np.append(0.0, along * inverse)) / (2 * c)
    of_roots = np.column_stack((b + 1, -2 * c, 1 - b)) * pull[:, None]
    of_inverses = np.column_stack((both + inverse, -2 * np.ones(N), inverse - both))
    w = np.concatenate((of_roots.ravel(), (of_inverses * along[:, None]).ravel()))
    # what is left is linear in b
    rise = bare.A[:, : N + 1]
    optimum = linprog(
        -2 * pull,
        vstack([rise, -rise]),
        np.repeat((_FASTER, _SLOWER), N),
        bounds=np.column_stack((np.zeros(N + 1), top)),
    )
    faster, slower = np.split(-optimum.ineqlin.marginals, 2)
    y = faster - slower
    x = np.concatenate((b, c, inverse, rise @ b))
    return Point(x, y, bare.C.T @ w - bare.q - bare.A.T @ y, w)


def witnessed(bare: Problem, *known: Point) -> Problem:
    """The problem with its tightest interval.

    It gets a cheap interior; the interval is that of engines' and known points.
    """
    engines = ("clarabel", "ecos") if bare.cones.size else ("clarabel", "piqp")
    points = list(known)
    for engine in engines:
        solve = prepare(engine, "own", bare)
        points += [solve(Ask(10.0**-digits, 60.0)).point for digits in range(9, 14)]
    best = replace(bare, interior=interior(bare))
    high = np.inf
    low = -np.inf
    for point in points:
        if point is None:
            continue
        if (value := upper_bound(best, point.x)) < high:
            high = value
            best = replace(best, x=point.x)
        if (value := lower_bound(best, point)) > low:
            low = value
            best = replace(best, y=point.y, z=point.z, w=point.w)
    return best


def interior(bare: Problem) -> FloatArray:
    """Optimum of the problem with everything tightened.

    Rows, bounds and cones are tightened by as much.

    On the way to it a point becomes feasible at about the least cost: its violation times the sum
    of the multipliers.
    """
    heads = np.zeros(bare.d.size)
    heads[np.cumsum(bare.cones) - bare.cones] = 1.0
    for margin in _MARGINS:
        rows = np.where(bare.equal, 0.0, margin)
        lower = {"l": bare.l + rows, "lb": bare.lb + margin}
        upper = {"u": bare.u - rows, "ub": bare.ub - margin}
        tight = replace(bare, **lower, **upper, d=bare.d - margin * heads)
        solve = prepare("clarabel", "own", tight)
        for digits in (9, 8, 7):
            result = solve(Ask(10.0**-digits, 60.0))
            if result.claim is Claim.OPTIMAL and result.point is not None:
                return np.clip(result.point.x, bare.lb, bare.ub)
    raise ProblemError(f"no interior: {result.status}")


class Frozen(NamedTuple):
    """A problem, its name, and its route."""

    name: str
    route: Scenario
    problem: Problem


def chosen(size: int) -> Iterator[Frozen]:
    """The problems of a size, without witnesses.

    Of each sequence every 12th QP counts; of all of them as many are taken as are wanted, evenly.
    """
    steps = []
    paths = []
    for place, (name, route) in enumerate(routes().items()):
        legs = len(route.via) + 1
        if not _LEAST_STEPS <= size // legs <= _MOST_STEPS:
            continue
        every, _ = sequence(route, size // legs)
        numbers = range(place % _BEGINNINGS, len(every), _EVERY)
        steps += [(f"{name}-{number}", route, every[number]) for number in numbers]
        paths.append((name, route, size // legs // 3))
    wanted = WANTED[size]
    for name, route, step in _evenly(steps, wanted["qp"], 0.25):
        yield Frozen(f"qp-{size}-{name}", route, box_qp(step))
    for name, route, step in _evenly(steps, wanted["tube"], 0.75):
        yield Frozen(f"tube-{size}-{name}", route, tube(step))
    for name, route, n in _evenly(paths, wanted["time"], 0.5):
        _, path = sequence(route, max(n, _LEAST_STEPS))
        if path is not None:
            yield Frozen(f"time-{size}-{name}", route, fastest(path))


def _evenly(items: list[Any], number: int, shift: float) -> list[Any]:
    return [items[int((k + shift) * len(items) / number)] for k in range(number)]


def trivial() -> Problem:
    """A trivial problem: the time of any call.

    It is x^2 / 2 - x over [0, 1], with a row that does not bind.
    """
    one, none = np.ones(1), np.zeros(0)
    return Problem(
        *(one, -one, csr_array([[1.0]]), -2 * one, 2 * one, 0 * one, one, csr_array((0, 1))),
        *(none, np.zeros(0, dtype=int), 0.5 * one, one, 0 * one, 0 * one, none),
    )


def write(problem: Problem, file: FilePath) -> str:
    """Write a problem as a compressed .npz file.

    Returns the SHA-256 of its bytes.
    """
    arrays: dict[str, Any] = {}
    for each in fields(problem):
        value = getattr(problem, each.name)
        if each.name in MATRICES:
            arrays |= {f"{each.name}_{part}": getattr(value, part) for part in CSR}
        else:
            arrays[each.name] = value
    np.savez_compressed(file, **arrays)
    return hashlib.sha256(file.read_bytes()).hexdigest()


def main() -> None:
    """Write all files and their list.

    The intervals are printed.
    """
    folder = FilePath(problem.__file__).with_name("problems")
    listed = {"trivial": {"sha256": write(trivial(), folder / "trivial.npz")}}
    for size in WANTED:
        for name, route, bare in chosen(size):
            known = [best_drive(bare)] if name.startswith("time") else []
            made = witnessed(bare, *known)
            digest = write(made, folder / f"{name}.npz")
            via = [list(point) for point in route.via]
            place = {"via": via, "target_x": route.target_x, "target_y": route.target_y}
            listed[name] = {"sha256": digest, "route": place}
            low, high = lower_bound(made, made.witness), upper_bound(made, made.x)
            print(f"{name:26} [{low:.12g}, {high:.12g}]  width {high - low:.1e}", flush=True)
    lines = [f'  "{name}": {json.dumps(entry)}' for name, entry in listed.items()]
    text = "{\n" + ",\n".join(lines) + "\n}\n"
    folder.joinpath("list.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
