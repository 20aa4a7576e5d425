"""The oracle against other ways to the same number, on a share of the cases."""

from __future__ import annotations

import math

import mpmath
import numpy as np
from flint import arb

from dubins_study.study.scenario import Scenario
from tests.adversary.oracle import DIGITS, WORDS, drive, lengths
from tests.adversary.table import Table, paste
from tests.adversary.truth import Truth

_STEPS = 6
_SCANNED = 2048  # first arcs of a scan
_CLEAR = 0.02  # radii from every edge, next to which a scan does not tell two roots apart


def oracle(table: Table, scenario: Scenario, truth: Truth, rng: np.random.Generator) -> None:
    line = f"Truth.of({paste(scenario)})"
    table.note("oracle by mpmath", _sine(scenario.heading), line)
    table.note("oracle by steps", _steps(truth, rng), line)
    wide = Truth(truth.target, arb(_CLEAR))
    if not any(wide.touches(word) for word in WORDS):
        table.note("oracle by scan", _scan(truth), line)


def _sine(heading: float) -> float:
    """Error of sine and cosine of the heading beside mpmath's, in 1e-60."""
    sin, cos = arb(heading).sin_cos()
    with mpmath.workdps(DIGITS + 20):
        pairs = ((sin, mpmath.sin(heading)), (cos, mpmath.cos(heading)))
        return max(
            float(abs(ball - arb(mpmath.nstr(number, DIGITS + 20)))) * 1e60
            for ball, number in pairs
        )


def _steps(truth: Truth, rng: np.random.Generator) -> bool:
    """Whether some first piece and the shortest way from its end beat the oracle's shortest."""
    best = truth.exact["best"]
    assert best is not None, "some path to every target exists"
    for turn in (-1, 0, 1):
        for step in (10 ** rng.uniform(-6, 0.8, _STEPS // 3)).tolist():
            z, direction = drive([(arb(turn), arb(step))])
            rest = lengths((truth.target - z) / direction)["best"]
            assert rest is not None
            if rest + step < best - arb(10.0) ** (10 - DIGITS) * (1 + best):
                return True
    return False


def _scan(truth: Truth) -> float:
    """Worst difference (in 1e-9 of max(length, 1)) from a search over the first arc in doubles."""
    target = complex(truth.target.real.mid(), truth.target.imag.mid())
    worst = 0.0
    for word in WORDS:
        exact, scanned = truth.exact[word], _scanned(target, word)
        if exact is None or scanned is None:
            worst = max(worst, 0.0 if exact is None and scanned is None else math.inf)
        else:
            worst = max(worst, abs(float(exact) - scanned) / max(1.0, float(exact)) * 1e9)
    return worst


def _scanned(target: complex, word: str) -> float | None:
    """The least length of a word by scanning its first arc and halving where the end crosses."""
    if word[0] == "R":
        target = target.conjugate()
    a = np.linspace(0, 2 * math.pi, _SCANNED + 1)
    off = _off(target, a, word[1] == "S")
    low = np.flatnonzero(off[:-1] * off[1:] <= 0)
    totals = [_halved(target, a[i], a[i + 1], word[1] == "S") for i in low]
    return min((total for total in totals if total is not None), default=None)


def _pose(a: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    direction = np.exp(1j * np.asarray(a))
    return 1j - 1j * direction, direction


def _off(target: complex, a: np.ndarray | float, straight: bool) -> np.ndarray:
    """How far the line or circle that follows a first left arc passes beside the target."""
    z, direction = _pose(a)
    seen = (target - z) / direction
    return np.asarray(seen.imag if straight else np.abs(seen + 1j) - 1)


def _halved(target: complex, low: float, high: float, straight: bool) -> float | None:
    for _ in range(60):
        middle = (low + high) / 2
        same = _off(target, low, straight) * _off(target, middle, straight) > 0
        low, high = (middle, high) if same else (low, middle)
    z, direction = _pose(low)
    seen = complex((target - z) / direction)
    if straight:
        return low + seen.real if seen.real >= 0 else None
    # clockwise about -i from the top
    angle = (math.pi / 2 - math.atan2(seen.imag + 1, seen.real)) % (2 * math.pi)
    return float(low + angle)
