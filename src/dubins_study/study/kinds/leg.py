"""One leg with a free final heading.

It is answered by the closed form; its region and its cut are measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from dubins_study.study.body_coordinates import local
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.extremal import measure
from dubins_study.study.check.verdict import ROUNDED, is_wrong_basin, path_word_of, visited
from dubins_study.study.closed_form.shortest import (
    Shortest,
    margin_local,
    region_of,
    shortest,
    shortest_local,
    shortest_path,
)
from dubins_study.study.kinds.kind import Arrived, Costates, Exact, Found, Kind, Reference
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import BRANCHES, FREE_FINAL_HEADING, TURN, Verdict


def _exact(scenario: Scenario, branch: str, limit: float) -> Exact:
    return Exact.known(shortest_path(scenario, branch))


def _exists(scenario: Scenario, branch: str) -> bool:
    return shortest(scenario, branch) is not None


def _reference(scenario: Scenario, branch: str, tolerances: Tolerances) -> Reference:
    return _to_any_heading(scenario, branch)


@lru_cache(maxsize=16384)  # many cells of a run ask the same question
def _to_any_heading(scenario: Scenario, branch: str) -> Reference:
    return Reference(enclose(scenario, branch), shortest_path(scenario, branch), ())


@lru_cache(maxsize=16384)
def _optimum(scenario: Scenario, branch: str) -> tuple[Shortest | None, dict[str, Any]]:
    """Shortest path of a question, and some columns.

    The path is None where the branch has none. The columns are those of a judgement that the
    question alone decides, whatever the answer.
    """
    target = local(scenario)
    optimum = shortest_local(target, branch)
    columns: dict[str, Any] = {
        "region": region_of(target.w, target.mirrored.w),
        "margin": margin_local(target.X, abs(target.Y)),
    }
    if optimum is not None:
        columns["reference_word"] = optimum.word
        columns["reference"] = optimum.total * scenario.radius
    return optimum, columns


def _known(scenario: Scenario, branch: str) -> dict[str, Any]:
    return _optimum(scenario, branch)[1]


def _ties(scenario: Scenario, branch: str) -> tuple[str, ...]:
    optimum = shortest(scenario, branch)
    if optimum is None:
        return ()
    return optimum.words


def _word_of(path: Path, at: Sequence[float], radius: float) -> str:
    return path_word_of(path)


def _verdict(scenario: Scenario, arrived: Arrived, tolerances: Tolerances) -> Found:
    """Verdict on a path that arrives with any heading.

    It is compared with `_shortest_length`, or with what `_known_to_delta` makes of that length.
    """
    path, branch, _, word = arrived
    shortest_length = _shortest_length(scenario, arrived)
    if shortest_length is None:
        return Found(Verdict.MISSES, {})
    reference = _known_to_delta(
        scenario, branch, length=path.length, reference=shortest_length, gap=tolerances.gap
    )
    gap = (path.length - reference) / max(reference, scenario.radius)
    columns = {"reference": reference, "gap": gap}
    if not gap > tolerances.gap:
        return Found(Verdict.OPTIMAL, columns)
    words, turns = _basins(_optimum(scenario, branch)[0])
    basin = is_wrong_basin(path, word, gap, words, turns)
    return Found(Verdict.LONGER, columns | {"wrong_basin": basin})


def _shortest_length(scenario: Scenario, arrived: Arrived) -> float | None:
    """Shortest length that a path is compared with.

    It is the scenario's. Only a miss makes a shorter path possible. A shorter path is compared with
    the shortest path to its own end, so that missing brings no advantage. If the branch has no path
    to either, a point within the miss may have one; the result is None if it has none.
    """
    path, branch, seen, _ = arrived
    known: float | None = _known(scenario, branch).get("reference")
    if known is not None and not path.length < known * (1.0 - ROUNDED):
        return known
    to_own_end = shortest(visited(scenario, seen.visits, seen.end), branch)
    if to_own_end is not None:
        # the end may be rounded to the other side of a circle, where all paths are longer
        return min(to_own_end.total * scenario.radius, path.length)
    if known is not None:
        return known
    target = local(scenario)
    assert scenario.target is not None
    # a target counts as on a circle within delta / 2: hence twice the miss
    off = 2.0 * math.dist(seen.end[:2], scenario.target)
    within_miss = target._replace(delta=target.delta + off / scenario.radius)
    nearby = shortest_local(within_miss, branch)
    if nearby is None:
        return None
    return nearby.total * scenario.radius


def _known_to_delta(
    scenario: Scenario, branch: str, length: float, reference: float, gap: float
) -> float:
    """Reference for data that are known to delta.

    For a longer answer, it is the longest shortest length, over targets within delta, that is not
    above the answer's length. For any other answer, `reference` is returned as it is.
    """
    allowed = gap * max(reference, scenario.radius)
    if length - reference <= allowed:
        return reference
    nearest = enclose(scenario, branch).nearest(length, allowed)
    if nearest is None:
        return reference
    # a change of length by delta alone is no reason for another reference
    if length - nearest <= allowed or nearest - reference > allowed:
        return nearest
    return reference


def _basins(optimum: Shortest | None) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Words and net turns of the shortest path.

    Returns two tuples; turns are in rad. A tie adds the mirror image to both. Without a path both
    are empty.
    """
    if optimum is None:
        return (), ()
    lengths = [length for length in optimum.segments if length > 0]
    turn = sum(TURN[c] * length for c, length in zip(optimum.word, lengths, strict=True))
    return optimum.words, (turn, -turn)[: len(optimum.words)]


def _costates(scenario: Scenario, path: Path, judgement: Judgement, until: float) -> Costates:
    """Costates and cut margin of a path.

    Any path that can be driven is measured, since a path is an extremal to wherever it ends.
    """
    if judgement.length is None:
        return Costates()
    return Costates(*measure(path, scenario.radius, free=True))


LEG = Kind(
    name="leg",
    title="one leg with a free final heading",
    fields={"searched": False, "final_heading": False},
    branches=BRANCHES,
    exact=_exact,
    exists=_exists,
    reference=_reference,
    known=_known,
    words_of=_word_of,
    verdict=_verdict,
    costates=_costates,
    ties=_ties,
    by_interval=False,
    need_of_rows=FREE_FINAL_HEADING,
    drawing="circles",
)
