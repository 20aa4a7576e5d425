"""Paths against an ODE integrator, geometry and symmetry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import integrated
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose

arcs = st.lists(st.tuples(st.floats(-3, 3), st.floats(0, 5)), max_size=8)


def path_of(pieces: list[tuple[float, float]]) -> Path:
    return Path(Pose(1.0, -2.0, 0.7), [k for k, _ in pieces], [length for _, length in pieces])


@given(arcs)
def test_end_pose_is_what_an_ode_integrator_finds(pieces):
    """The exact arcs agree with DOP853 at 1e-12, whose error over 40 lengths stays below 1e-9."""
    path = path_of(pieces)

    np.testing.assert_allclose(np.array(path.end), integrated(path), atol=1e-9)


def test_an_almost_straight_arc_keeps_its_digits():
    """Curvature 1e-12 is a straight line to rounding; 1/k would lose four digits here."""
    path = Path(Pose(0, 0, 0), [1e-12], [10.0])

    np.testing.assert_allclose(path.end, (10.0, 5e-11, 1e-11), rtol=1e-12)


@given(arcs, st.integers(2, 50))
def test_samples_lie_on_the_path(pieces, n):
    """Samples begin and end where the path does and are nowhere further apart than along it."""
    path = path_of(pieces)
    poses = path.sample(n)

    np.testing.assert_allclose(poses[0], path.start, atol=1e-12)
    np.testing.assert_allclose(poses[-1], path.end, atol=1e-9)
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert (steps <= path.total_length / (n - 1) + 1e-9).all()


@given(arcs)
def test_cutting_a_path_finer_changes_nothing(pieces):
    """Every arc cut into three ends at the same pose and has the same word."""
    path = path_of(pieces)
    finer = path_of([(k, length / 3) for k, length in pieces for _ in range(3)])

    np.testing.assert_allclose(finer.end, path.end, atol=1e-9)
    assert finer.word() == path.word()


@given(arcs, st.floats(0.01, 100))
def test_mirror_and_scale(pieces, factor):
    """The mirror image ends mirrored with L and R exchanged; lengths and ends scale."""
    path = path_of(pieces)
    x, y, heading = path.end

    start = path.start
    mirrored = Path(Pose(start.x, -start.y, -start.heading), -path.curvature, path.length)
    np.testing.assert_allclose(mirrored.end, (x, -y, -heading), atol=1e-9)
    assert mirrored.word() == path.word().translate(str.maketrans("LR", "RL"))
    scaled_start = Pose(start.x * factor, start.y * factor, start.heading)
    scaled = Path(scaled_start, path.curvature / factor, path.length * factor)
    np.testing.assert_allclose(scaled.end, (x * factor, y * factor, heading), rtol=1e-9, atol=1e-9)
    assert scaled.total_length == pytest.approx(path.total_length * factor)
    assert scaled.word() == path.word()


@pytest.mark.parametrize(
    ("pieces", "word"),
    [
        ([], ""),
        ([(1, 0), (-1, 0)], ""),
        ([(1, 1), (0, 2)], "LS"),
        ([(-1, 1), (1, 4)], "RL"),
        ([(0, 5)], "S"),
        ([(1, 1), (1, 1), (0.3, 1), (0, 2), (1e-9, 1), (-1e-9, 1)], "LS"),
        ([(1, 1e-9), (-1, 2)], "R"),
        ([(1, 1), (-1, 2), (0, 3)], "LRS"),
        ([(math.nan, 1)], ""),
    ],
)
def test_words(pieces, word):
    assert path_of(pieces).word() == word


def test_shapes_must_agree():
    with pytest.raises(ValueError, match=r"shape \(2,\) and length \(1,\)"):
        Path(Pose(0, 0, 0), [1, 2], [1])


def test_a_path_cannot_be_changed():
    path = Path(Pose(0, 0, 0), [1], [1])

    with pytest.raises(ValueError, match="read-only"):
        path.length[0] = 2
