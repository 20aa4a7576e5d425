"""Pontryagin's conditions and the cut over arrays: `study.check.extremal` for paths of two arcs.

The words S, C, CS and CC at full rate have their costates in closed form (docs/derivation.md,
section 9), by `two_arcs.costates`, compiled. Other rows are left to `extremal`.
"""

from __future__ import annotations

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from dubins_study.study.check import two_arcs
from dubins_study.study.check.extremal import ABNORMAL
from dubins_study.study.closed_form.kernel_compile import compiled, inlined
from dubins_study.study.path import FloatArray

_costates = inlined(two_arcs.costates)
_word_of = inlined(two_arcs.word_of)
for _called in two_arcs.CALLED:
    register_jitable(_called)


@compiled
def extremal_rows(
    heading: FloatArray,
    radius: FloatArray,
    curvature: FloatArray,
    length: FloatArray,
    measured: FloatArray,
    abnormal: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Fill `measured` and `abnormal`; returns which rows are left, shape (n,).

    Args:
        heading: start headings (rad), shape (n,).
        radius: turning radii (length unit), shape (n,).
        curvature: shape (2, n), 1 / length unit.
        length: shape (2, n), length unit.
        measured: shape (7, n), rows as `study.check.extremal.MEASURED`.
        abnormal: shape (n,).
    """
    n = heading.size
    left = np.zeros(n, np.bool_)
    for i in range(n):
        R = radius[i]
        u1, u2 = curvature[0, i] * R, curvature[1, i] * R
        l1, l2 = length[0, i] / R, length[1, i] / R
        word = _word_of(u1, l1, u2, l2)
        if not word.named:
            left[i] = True
            continue
        nu0, rho, phi, H, margin, cut = _costates(word.turn1, word.first, word.turn2, word.second)
        abnormal[i] = nu0 < ABNORMAL
        scale = rho if abnormal[i] else rho / nu0
        # turned by the heading on its own: added to one of many turns, phi loses its digits
        c, s = math.cos(heading[i]), math.sin(heading[i])
        measured[0, i] = scale * (c * math.cos(phi) - s * math.sin(phi))
        measured[1, i] = scale * (s * math.cos(phi) + c * math.sin(phi))
        measured[2, i] = H
        measured[3, i] = margin
        measured[4, i] = 0.0
        measured[5, i] = max(H, -margin)
        measured[6, i] = cut
    return left
