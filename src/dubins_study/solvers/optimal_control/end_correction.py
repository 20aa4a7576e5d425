"""The way from a transcription's controls, integrated exactly, back to the target."""

from __future__ import annotations

import numpy as np

from dubins_study.solvers.optimal_control.elements import Elements
from dubins_study.solvers.optimal_control.turn_rate_dynamics import (
    CLOSE,
    Controls,
    Rates,
    corrected,
    rollout,
)
from dubins_study.study.path import FloatArray

_STEPS = 30  # Newton's method takes 1 to 4; more are needed where bounds cut steps short
_WITHIN = 0.9  # the share of the way to a bound that a step may go


def miss(elements: Elements, target: FloatArray) -> float:
    """Distance (radii) from where the controls, integrated exactly, end to the target (2,)."""
    end = elements.path.end
    return float(np.hypot(end.x - target[0], end.y - target[1]))


def closed(
    elements: Elements, rates: Rates, target: FloatArray, equal: bool
) -> tuple[Elements, float, int]:
    """Change the controls as little as needed for the path to end at the target.

    Newton's method on the two equations of the end point, in the rates and the lengths (only in
    the whole length if all are `equal`). Every variable is measured in units of its distance from
    its bounds, and the smallest step that solves the linearised equations is taken. So a variable
    that the solver left at a bound stays there. The solver's point is stationary in the others:
    to first order the length changes by no more than if the target had moved by the miss. Where no
    variable is free, as on a turning circle, this does not arrive; the rates then change as needed.

    Returns the elements, the miss (radii) and the number of rollouts.
    """
    # rounding of such coordinates leaves a miss of this size
    close = max(CLOSE, 8 * np.finfo(float).eps * float(np.abs(target).sum()))
    moved, rollouts = elements, 0
    for _ in range(_STEPS):
        rollouts += 1
        if not moved.total > 0 or (off := miss(moved, target)) <= close:
            break
        moved = _step(moved, rates, target, equal)
    off = miss(moved, target)
    if off <= close or not elements.total > 0:
        return moved, off, rollouts
    shares = elements.length / elements.total
    some = elements.length > 0
    controls = Controls(np.cumsum(elements.turn[some]), elements.total)
    bent, off, used = corrected(controls, shares[some], rates, target, close)
    turn = np.zeros_like(elements.turn)
    turn[some] = bent.turns
    return Elements(turn, shares * bent.length), off, rollouts + used


def _step(elements: Elements, rates: Rates, target: FloatArray, equal: bool) -> Elements:
    turn, length = elements
    rate, total = elements.rate, elements.total
    rolled = rollout(Controls(np.cumsum(turn), total), length / total)
    by_turn = np.cumsum(rolled.gradient[:, ::-1], axis=1)[:, ::-1]
    # derivatives by a rate in units of its distance to the nearer bound, and by a length at a
    # fixed rate
    slack = np.minimum(rate - rates.lower, rates.upper - rate)
    by_rate = by_turn * (length * slack)
    by_length = rolled.chords + by_turn * turn
    if equal:
        by_length = by_length.sum(axis=1, keepdims=True)
    jacobian = np.column_stack((by_rate, by_length))
    step = np.linalg.lstsq(jacobian, target - rolled.end, rcond=None)[0]
    step *= min(1.0, _WITHIN / max(float(np.abs(step).max()), 1e-300))
    rate = np.clip(rate + step[: turn.size] * slack, rates.lower, rates.upper)
    length = length * (1.0 + step[turn.size :])
    return Elements(rate * length, length)
