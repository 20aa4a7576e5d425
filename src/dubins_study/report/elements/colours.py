"""The hues of figures, each for the light page and for the dark one; the hues of engines.

On either page a hue has a contrast of at least 3 to 1 (the ratio of WCAG 2.2, success criterion
1.4.11, for graphical objects). The engines' hues are as far apart as ten can be at that contrast,
also for readers with protanopia or deuteranopia; the test of this module measures it.
"""

from __future__ import annotations

from typing import NamedTuple


class Hue(NamedTuple):
    """One hue's values, `#rrggbb`."""

    light: str
    dark: str


# Hues of kinds: verdicts, proofs, parts of a cost. From dark to light and hatched where they meet.
HUES = {
    "blue": Hue("#0072b2", "#4aa8e0"),
    "vermilion": Hue("#d55e00", "#f08a4b"),
    "green": Hue("#009e73", "#2fc39a"),
    "orange": Hue("#b87a00", "#e6ac3a"),
    "sky": Hue("#3d93cb", "#8ccbf0"),
    "purple": Hue("#b45a8c", "#dd94bd"),
    "brown": Hue("#7a3b12", "#c98a5e"),
    "olive": Hue("#7a7100", "#b8ae3c"),
}

# Hues of engines, in the order in which engines get them.
ENGINE_HUES = (
    Hue("#1473b2", "#4696cb"),  # blue
    Hue("#ba5f47", "#ef790f"),  # orange
    Hue("#14a381", "#1fc09d"),  # teal
    Hue("#732623", "#c4604d"),  # brown
    Hue("#8a5ae4", "#b981fe"),  # violet
    Hue("#b88302", "#efcc31"),  # ochre
    Hue("#2b2f9e", "#6b6df1"),  # navy
    Hue("#535f09", "#a1c266"),  # olive
    Hue("#c0388e", "#f399cf"),  # magenta
    Hue("#0f9cd4", "#9ddcff"),  # sky
)
_NAMED = HUES | {f"engine-{place}": hue for place, hue in enumerate(ENGINE_HUES, 1)}

# Value in a figure's file -> the page's variable, so that a figure follows the page's mode.
VARIABLES = {hue.light: f"--{name}" for name, hue in _NAMED.items()}


def css_values(mode: str) -> str:
    """The declarations of all hues' variables for one mode of the page, `light` or `dark`."""
    return " ".join(f"--{name}: {getattr(hue, mode)};" for name, hue in _NAMED.items())
