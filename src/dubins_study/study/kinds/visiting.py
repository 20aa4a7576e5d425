"""Verdict on paths that meet points or headings.

The kinds with such paths share it. Their references are intervals.
"""

from __future__ import annotations

from collections.abc import Callable

from dubins_study.study.check.enclosure import Enclosure, Part
from dubins_study.study.check.verdict import ROUNDED, is_wrong_basin, visited, words_of
from dubins_study.study.kinds.kind import Arrived, Found, Reference
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Verdict

# Change of the optimal length that is allowed for, per shift of the target. It is 1 where the path
# ends straight, and more near a turning circle, where the change itself varies within the shift.
_STEEP = 10.0


def verdict(
    scenario: Scenario,
    arrived: Arrived,
    tolerances: Tolerances,
    *,
    reference_of: Callable[[Scenario, str, Tolerances], Reference],
    compared: Callable[[Enclosure, float, float], Part],
) -> Found:
    """Verdict on a path that arrives.

    The path is compared with the scenario's reference. If it is shorter by more than its misses
    explain, it is compared with the reference of the points that it visits.

    Args:
        scenario, arrived, tolerances: as `Kind.verdict` has them.
        reference_of: the kind's own.
        compared: the shortest and longest length that the reference may have, from its enclosure,
            the path's length and its tolerance.
    """
    path, branch, seen, word = arrived
    radius = scenario.radius
    length = path.length
    allowed = tolerances.gap
    best = reference_of(scenario, branch, tolerances)
    # how much shorter the misses of points and headings can make a path
    moved = _STEEP * (scenario.legs * seen.miss + seen.turned * radius)
    if length < best.enclosure.low * (1.0 - ROUNDED) - moved:
        own_scenario = visited(scenario, seen.visits, seen.end)
        best = reference_of(own_scenario, branch, tolerances)
    if best.path is None or not best.enclosure.exists:
        return Found(Verdict.MISSES, {})
    low, high = compared(best.enclosure, length, allowed * max(best.enclosure.low, radius))
    above = (length - low) / max(low, radius)
    reference_word = words_of(best.path, best.at, radius)
    columns = {"reference": low, "gap": above, "reference_word": reference_word}
    if above <= allowed:
        return Found(Verdict.OPTIMAL, columns)
    # longer than the low end of the reference, but not than its high end
    if (length - high) / max(high, radius) <= allowed:
        return Found(Verdict.UNDECIDED, columns)
    basin = is_wrong_basin(path, word, above, (reference_word,), (best.path.turn,))
    return Found(Verdict.LONGER, columns | {"wrong_basin": basin})
