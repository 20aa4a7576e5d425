"""The drawing of a path in a notebook: an SVG whose arcs are arcs."""

from __future__ import annotations

import numpy as np

from dubins_study.study.arrays import FloatArray

_SIDE, _MARGIN = 300.0, 10.0  # pixels of the longer side, and around it
_FLAT = 0.05  # pixels between an arc and its chord; a flatter arc is drawn as its chord


def svg(points: FloatArray, ends: FloatArray, curvatures: FloatArray, caption: str) -> str:
    """A line drawing of arcs, above a caption, with a dot at the start.

    Args:
        points: on the path, close enough to tell how large it is, shape (n, 2).
        ends: of arcs of at most half a turn, the start first, shape (m + 1, 2).
        curvatures: of these arcs, shape (m,), positive to the left.
        caption: a text without characters that mean something to XML.
    """
    flip = np.array([1, -1])  # SVG's y points down
    low = (points * flip).min(axis=0)
    size = np.ptp(points, axis=0)
    scale = _SIDE / float(size.max())
    drawn = (ends * flip - low) * scale + _MARGIN
    chords = np.hypot(*np.diff(drawn, axis=0).T)
    bends = np.abs(curvatures) / scale
    line = ["M{:.2f} {:.2f}".format(*drawn[0])]
    for (x, y), chord, bend, k in zip(drawn[1:], chords, bends, curvatures, strict=True):
        curve = "L"
        if chord * chord * bend / 8 > _FLAT:
            curve = f"A{1 / bend:.2f} {1 / bend:.2f} 0 0 {int(k < 0)} "
        line.append(f"{curve}{x:.2f} {y:.2f}")
    x, y = drawn[0]
    width, height = size * scale + (2 * _MARGIN, 4 * _MARGIN)
    width = max(width, 7.5 * len(caption) + 2 * _MARGIN)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}">'
        f"<title>{caption}</title>"
        f'<path d="{"".join(line)}" fill="none" stroke="#0072b2" stroke-width="2" '
        'stroke-linejoin="round"/>'
        f'<circle cx="{x:.2f}" cy="{y:.2f}" r="4" fill="#0072b2"/>'
        f'<text x="{_MARGIN:.0f}" y="{height - 1.5 * _MARGIN:.0f}" fill="#767676" '
        f'font-family="sans-serif" font-size="13">{caption}</text></svg>'
    )
