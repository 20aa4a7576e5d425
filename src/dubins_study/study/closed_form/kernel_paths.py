"""Controls of many paths at once: from word codes, and as the flat lists that a table keeps."""

from __future__ import annotations

import numpy as np

from dubins_study.study.closed_form.kernel import WORDS
from dubins_study.study.closed_form.kernel_compile import compiled
from dubins_study.study.closed_form.kernel_words import CodeArray
from dubins_study.study.path import FloatArray
from dubins_study.study.words import TURN

# the turn of each word's first and of its last letter; a segment left out has no length
FIRST_TURN = np.array([TURN[word[0]] if word else 0.0 for word in WORDS])
LAST_TURN = np.array([TURN[word[-1]] if word else 0.0 for word in WORDS])


@compiled
def curvatures(word: CodeArray, radius: FloatArray, out: FloatArray) -> None:
    """Curvatures of both segments of each word, into `out` of shape (2, n), 1 / length unit."""
    for i in range(word.size):
        code = word[i] if word[i] < FIRST_TURN.size else 0
        out[0, i] = FIRST_TURN[code] / radius[i]
        out[1, i] = LAST_TURN[code] / radius[i]


@compiled
def flatten(
    curvature: FloatArray,
    length: FloatArray,
    offsets: np.ndarray[tuple[int], np.dtype[np.int64]],
    flat_curvature: FloatArray,
    flat_length: FloatArray,
) -> None:
    """The arcs that have a length, path after path.

    Args:
        curvature, length: controls of n paths, shape (2, n).
        offsets: out, shape (n + 1,): where each path begins in the flat arrays.
        flat_curvature, flat_length: out, with room for 2 n.
    """
    place = 0
    offsets[0] = 0
    for i in range(curvature.shape[1]):
        # written in any case and overwritten if it does not count: quicker than a branch
        flat_curvature[place], flat_length[place] = curvature[0, i], length[0, i]
        place += length[0, i] != 0.0
        flat_curvature[place], flat_length[place] = curvature[1, i], length[1, i]
        place += length[1, i] != 0.0
        offsets[i + 1] = place
