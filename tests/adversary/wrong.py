"""Answers that are wrong, or right in an unusual shape, each to a scenario of its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from flint import arb, ctx

from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES
from tests.adversary.oracle import drive

_BITS = 320


class Answer(NamedTuple):
    """A path that is put before the check, and its question."""

    scenario: Scenario
    branch: str
    path: Path


Alter = Callable[[np.random.Generator, Scenario, Path], Answer]


def _branch(rng: np.random.Generator) -> str:
    return str(rng.choice(BRANCHES)) if rng.random() < 0.4 else "best"


def _with_end_as_target(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """The question whose target is the path's own end, rounded to doubles."""
    with ctx.workprec(_BITS):
        controls = zip(path.curvature.tolist(), path.length.tolist(), strict=True)
        moved = drive([(arb(k), arb(s)) for k, s in controls])[0]
        sin, cos = arb(scenario.heading).sin_cos()
        x = float(arb(scenario.x) + moved.real * cos - moved.imag * sin)
        y = float(arb(scenario.y) + moved.real * sin + moved.imag * cos)
    return Answer(replace(scenario, target_x=x, target_y=y), _branch(rng), path)


def other_word(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """The shortest path of one branch as the answer to another."""
    other = shortest_path(scenario, str(rng.choice(BRANCHES)))
    return Answer(scenario, _branch(rng), path if other is None else other)


def full_turn(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """A full turn too much."""
    k = float(rng.choice((-1, 1))) / scenario.radius
    turn = 2 * math.pi * scenario.radius
    return Answer(
        scenario, _branch(rng), Path(scenario.start, [k, *path.curvature], [turn, *path.length])
    )


def altered_length(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """One length changed by any share: the path misses by more than the tolerance, or by less."""
    lengths = path.length.copy()
    if lengths.size:
        lengths[rng.integers(lengths.size)] *= 1 + rng.choice((-1, 1)) * 10 ** rng.uniform(-14, 0)
    return Answer(scenario, _branch(rng), Path(scenario.start, path.curvature, lengths))


def altered_curvature(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """One curvature changed by any share; the target is the new end, or stays."""
    curvature = path.curvature.copy()
    if curvature.size:
        share = 1 + rng.choice((-1, 1)) * 10 ** rng.uniform(-14, -1)
        curvature[rng.integers(curvature.size)] *= share
    changed = Path(scenario.start, curvature, path.length)
    if rng.random() < 0.5:
        return Answer(scenario, _branch(rng), changed)
    return _with_end_as_target(rng, scenario, changed)


def cut_up(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """The right path cut into many pieces, which is as right."""
    n = int(rng.integers(2, 12))
    curvature, length = np.repeat(path.curvature, n), np.repeat(path.length / n, n)
    return Answer(scenario, "best", Path(scenario.start, curvature, length))


def tiny_pieces(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """Arcs with straights between them that are short beside the whole path, then a long way."""
    R = scenario.radius
    n, long = int(rng.integers(1, 100)), 10 ** rng.uniform(0, 7)
    straight = long * 10 ** rng.uniform(-9, -5) * rng.choice((0.1, 0.99, 1))
    curvature = np.tile([1.0, 0.0], n).tolist()
    length = np.tile([3.14 / n, straight], n).tolist()
    if rng.random() < 0.3:
        # turns too small to count, to both sides
        curvature += [1.0, -1.0] * 5
        length += [10 ** rng.uniform(-9, -5)] * 10
    k, s = np.array([*curvature, 0.0]) / R, np.array([*length, long]) * R
    return _with_end_as_target(rng, scenario, Path(scenario.start, k, s))


def random_pieces(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """One to six pieces at full rate or less, the target at their end."""
    n = int(rng.integers(1, 7))
    u = rng.choice((-1.0, 0.0, 1.0), n) if rng.random() < 0.7 else rng.uniform(-1, 1, n)
    s = rng.uniform(0, 4, n) if rng.random() < 0.5 else 10 ** rng.uniform(-8, 1, n)
    R = scenario.radius
    return _with_end_as_target(rng, scenario, Path(scenario.start, u / R, s * R))


def two_pieces(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """Two pieces at full rate, the target at their end: right for short arcs, wrong beyond."""
    first = float(rng.choice((-1, 1)))
    last = float(rng.choice((0.0, -first)))
    R = scenario.radius
    s = rng.uniform(0, 2 * math.pi, 2) * R
    return _with_end_as_target(rng, scenario, Path(scenario.start, np.array([first, last]) / R, s))


def broken(rng: np.random.Generator, scenario: Scenario, path: Path) -> Answer:
    """A path that nothing can drive: a negative length, or a number that is not finite."""
    curvature, length = [*path.curvature, 1 / scenario.radius], [*path.length, scenario.radius]
    place = int(rng.integers(len(length)))
    bad = float(rng.choice((-4.59, math.nan, math.inf, -1e-12)))
    if bad < 0 or rng.random() < 0.5:
        length[place] = bad * scenario.radius
    else:
        curvature[place] = bad
    short = slice(-2, None)  # two pieces, so that the frame takes it too
    return Answer(scenario, _branch(rng), Path(scenario.start, curvature[short], length[short]))


KINDS: tuple[Alter, ...] = (
    other_word,
    full_turn,
    altered_length,
    altered_curvature,
    cut_up,
    tiny_pieces,
    random_pieces,
    two_pieces,
    broken,
)


def wrong_answer(rng: np.random.Generator, scenario: Scenario) -> tuple[str, Answer]:
    """One altered answer; its kind by name."""
    kind = KINDS[int(rng.integers(len(KINDS)))]
    path = shortest_path(scenario)
    assert path is not None, "some path to every target exists"
    return kind.__name__, kind(rng, scenario, path)
