"""The functions for two arcs against the general code for any number of arcs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from dubins_study.study.check.extremal import cut_margin, extremal, measure, pieces
from dubins_study.study.check.two_arcs import FULL_RATE, PATH_WORDS, path_word, word_of
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose

SIZES = st.sampled_from([0.0, 1e-12, 1e-7, 9e-7, 2e-6, 1e-4, 0.3, 1.0, 5.0, 1e3])
LENGTHS = st.one_of(st.floats(1e-9, 10.0), SIZES.filter(bool))
RATES = st.one_of(
    st.sampled_from([-1.0, 0.0, 1.0, 1 + 1e-10, -1e-10, 0.5, 1e-3, -1e-3, 2e-3, 1e-7]),
    st.floats(-2, 2),
)


@given(RATES, LENGTHS, RATES, LENGTHS)
def test_the_word_of_two_arcs_is_the_word_of_the_path(k1, l1, k2, l2):
    """Ripples, turns of next to nothing and straights of next to no length included."""
    expected = Path(Pose(0, 0, 0), [k1, k2], [l1, l2]).word()

    assert PATH_WORDS[path_word(k1, l1, k2, l2)] == expected


@given(RATES, SIZES, RATES)
def test_an_arc_of_no_length_is_no_arc(k, length, other):
    one = path_word(k, length, 0.0, 0.0)

    assert path_word(k, length, other, 0.0) == one
    assert path_word(other, 0.0, k, length) == one
    if length:
        assert PATH_WORDS[one] == Path(Pose(0, 0, 0), [k], [length]).word()


@given(
    st.sampled_from([(1, 0), (-1, 0), (1, -1), (-1, 1), (1,), (-1,), (0,)]),
    st.floats(1e-3, 6.2),
    st.floats(1e-3, 6.2),
    st.floats(-1, 1).map(lambda z: z * 0.9 * FULL_RATE),
    st.floats(-4, 4),
    st.floats(0.1, 50),
)
def test_costates_in_closed_form_are_the_null_vector(turns, first, second, off, heading, radius):
    """Of S, C, CS and CC at full rate: the linear conditions, solved, have the same costates.

    Two arcs that turn by less than half a turn at the end violate the conditions. The null vector
    spreads the violation over all of them, the closed form puts it into the sign of nu3: only that
    there is one is the same.
    """
    assume(abs(second - math.pi) > 1e-3)  # costates have no bound there
    lengths = np.array([first, second][: len(turns)]) * radius
    curvature = np.array([t + off * (t != 0) for t in turns]) / radius
    path = Path(Pose(1, -2, heading), curvature, lengths)
    quick, cut = measure(path, radius)
    general = extremal(pieces(path, radius))

    assert cut == pytest.approx(cut_margin(pieces(path, radius)), abs=1e-12)
    assert quick.abnormal == general.abnormal
    assert (quick.residual <= 1e-7) == (general.residual <= 1e-7)
    if general.residual <= 1e-7:
        assert quick.nu == pytest.approx(general.nu, rel=1e-4, abs=1e-7)
        assert quick.sign_margin == pytest.approx(general.sign_margin, abs=1e-7)
        assert abs(quick.hamiltonian - general.hamiltonian) <= 1e-7


@pytest.mark.parametrize("u", [math.nan, math.inf, -1e300, 0.999, 0.5, 2.0, 2e-9])
def test_other_rates_name_no_word(u):
    assert not word_of(u, 1.0, 0.0, 1.0).named
    assert not word_of(1.0, 1.0, u, 1.0).named
