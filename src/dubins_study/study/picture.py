"""Draw a path for a notebook."""

from __future__ import annotations

import numpy as np

from dubins_study.study.arrays import FloatArray

_SIDE = 300.0  # pixels of the longer side
_MARGIN = 10.0  # pixels around the picture


def svg(points: FloatArray, caption: str) -> str:
    """Draw a line through points, as SVG.

    A dot marks the start, and a caption stands below.

    Args:
        points: on the path, shape (n, 2).
        caption: a text without characters that mean something to XML.
    """
    flip = np.array([1, -1])  # SVG's y points down
    low = (points * flip).min(axis=0)
    size = np.ptp(points, axis=0)
    scale = _SIDE / float(size.max())
    corners = [f"{x:.2f},{y:.2f}" for x, y in (points * flip - low) * scale + _MARGIN]
    x, y = corners[0].split(",")
    width, height = size * scale + (2 * _MARGIN, 4 * _MARGIN)
    # room for the caption: a character takes about 7.5 pixels
    width = max(width, 7.5 * len(caption) + 2 * _MARGIN)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}">'
        f"<title>{caption}</title>"
        f'<polyline points="{" ".join(corners)}" fill="none" stroke="#0072b2" stroke-width="2" '
        'stroke-linejoin="round"/>'
        f'<circle cx="{x}" cy="{y}" r="4" fill="#0072b2"/>'
        f'<text x="{_MARGIN:.0f}" y="{height - 1.5 * _MARGIN:.0f}" fill="#767676" '
        f'font-family="sans-serif" font-size="13">{caption}</text></svg>'
    )
