"""Numbers, durations and names as text."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, TypeAlias

Format: TypeAlias = Callable[[Any], str]
ABSENT = "–"


def slug(text: str) -> str:
    """A text from outside, for a file's name.

    It has lower-case letters, digits and dashes, at most 60; `unnamed` if none is left.
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:60] or "unnamed"


def digits(n: int) -> Format:
    """A format (value -> text) with `n` significant digits.

    From 1e-3 up to 1e6 the notation is plain, beyond it is like 1.5e7. A whole number has thin
    spaces between thousands, as `count` writes them.
    """

    def show(value: Any) -> str:
        number = float(value)
        if number == 0:
            return "0"
        if number == math.inf:
            return "∞"
        if not math.isfinite(number):
            return ABSENT
        mantissa, _, power = f"{number:.{n - 1}e}".partition("e")
        exponent = int(power)
        decimals = n - 1 - exponent
        if not -4 < exponent < 6:
            text = f"{mantissa}e{exponent}"
        elif decimals > 0:
            text = f"{number:.{decimals}f}"
        else:
            text = count(round(number))
        return text.replace("-", "−")

    return show


def share(value: Any) -> str:
    """A share from 0 to 1 as a percentage.

    Only 1 itself is written as 100 %, and only 0 as 0 %. Shares near them become `<0.1 %` and
    `>99.9 %`.
    """
    percent = 100 * float(value)
    if 0 < percent < 0.1:
        return "<0.1 %"
    if 99.9 < percent < 100:
        return ">99.9 %"
    if percent in (0, 100):
        return f"{percent:.0f} %"
    return f"{percent:.1f} %"


def count(value: Any) -> str:
    """A whole number with thin spaces between thousands."""
    return f"{int(value):,}".replace(",", "\u202f")


def some(number: int, noun: str) -> str:
    """A number with its noun: `1 row`, `2 rows`."""
    if number != 1:
        noun += "s"
    return f"{count(number)} {noun}"


def shortened(text: str, most: int) -> str:
    """A text cut to at most `most` characters.

    A text that was cut ends in `…`.
    """
    if len(text) <= most:
        return text
    return f"{text[: most - 1]}…"


def sentences(*each: str) -> str:
    """Join sentences to one paragraph, without empty ones."""
    return " ".join(filter(None, each))


def seconds(value: Any) -> str:
    """A duration (s), with three digits and unit."""
    number = float(value)
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if number >= factor:
            return f"{digits(3)(number / factor)} {unit}"
    return f"{digits(3)(number / 1e-9)} ns"
