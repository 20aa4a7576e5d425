"""An answer as terminal text or JSON object."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.output import plain
from dubins_study.study.words import Outcome, short_word

if TYPE_CHECKING:
    from dubins_study.asking.attempt import Answer
    from dubins_study.missions.flight import Flight

# Fields of an answer in the JSON object, which also has the question's, `given_order_length`,
# `segments`, `stops` and `tied_words`.
_JSON = (
    *("word", "length", "travel_time", "gap", "verdict", "claim", "outcome", "solver", "branch"),
    *("presolved", "miss", "region", "margin", "reference", "reference_word"),
    *("curvature_excess", "claimed_length", "lower_bound", "false_claim", "wrong_basin", "proof"),
    *("reference_low", "reference_high", "pmp_residual", "cut_margin", "false_bound"),
    *("native_status", "message", "build_s", "solve_s", "wall_s", "visits", "order"),
)

_MOST_SEGMENTS = 4  # of a path of many pieces, in the text
_MOST_POINTS = 24  # of an order
_SAME = 1e-8  # relative; two searches to 1e-9 each


def answer_json(
    answer: Answer,
    names: Sequence[str] = (),
    in_given_order: Answer | None = None,
    flight: Flight | None = None,
) -> str:
    """The answer and its question as a JSON object.

    The arguments are those of `answer_text`.
    """
    fields: dict[str, Any] = {name: getattr(answer, name) for name in _JSON}
    fields["via"] = [list(point) for point in answer.scenario.via]
    fields["names"] = list(names)
    fields["final_heading"] = answer.scenario.final_heading
    fields["closed"] = answer.scenario.closed
    fields["gap"] = _gap(answer)
    fields["start_heading"] = None
    if answer.path is not None:
        fields["start_heading"] = math.remainder(answer.path.start.heading, math.tau)
    fields["given_order_length"] = None
    fields["given_order_proof"] = None
    if in_given_order is not None:
        fields["given_order_length"] = in_given_order.length
        fields["given_order_proof"] = in_given_order.proof
    pieces = zip(answer.curvatures or (), answer.lengths or (), strict=True)
    fields["segments"] = [
        {"turn": _letter(k), "length": length, "curvature": k} for k, length in pieces
    ]
    fields["stops"] = []
    if flight is not None:
        fields["stops"] = [stop._asdict() for stop in flight.stops]
    fields["tied_words"] = list(answer.tied_words)
    return json.dumps(fields, indent=2, allow_nan=False)


def _letter(curvature: float) -> str:
    if curvature > 0:
        return "L"
    if curvature < 0:
        return "R"
    return "S"


def answer_text(
    answer: Answer,
    names: Sequence[str] = (),
    in_given_order: Answer | None = None,
    flight: Flight | None = None,
) -> str:
    """The answer as a few lines for the terminal.

    Where it has several stops, a table of them follows.

    Args:
        names: of the via points, some of which may be empty.
        in_given_order: the answer to a tour's points in the order in which they are given.
        flight: the answer's path beside the points that it passes.
    """
    fields: dict[str, str] = {}
    if answer.length is not None:
        fields["order"] = _order(answer, names)
        fields["word"] = _word(answer)
        fields["length"] = f"{answer.length:.12g}"
        fields["given order"] = _given_order(answer, in_given_order)
        fields["travel time"] = f"{answer.travel_time:.12g}"
        fields["segments"] = _segments(answer)
        fields["optimum"] = _optimum(answer)
        fields["shorter"] = _shorter(answer)
    fields["verdict"] = _verdict(answer)
    fields["claim"] = f"{answer.claim}  ({answer.solver})"
    if answer.presolved and answer.verdict == "none exists":
        fields["presolve"] = "answered, and the engine was not asked"
    fields["proof"] = _proof(answer)
    if answer.length is not None:
        fields["gap"] = _number(_gap(answer))
        fields["miss"] = _number(answer.miss)
    if answer.margin is not None:
        circle = f"{answer.margin:.3g} R from the nearer turning circle"
        fields["region"] = f"{answer.region}, {circle}"
    if answer.solve_s is not None:
        built = f"after {_milliseconds(answer.build_s or 0.0)} to build"
        fields["solve time"] = f"{_milliseconds(answer.solve_s)}, {built}"
    elif answer.wall_s is not None:  # it was not solved
        fields["ended after"] = _milliseconds(answer.wall_s)
    if answer.false_claim:
        fields["false claim:"] = "the claim is stronger than the verdict"
    if answer.false_bound:
        fields["false bound:"] = "the solver's lower bound lies above the shortest length"
    if answer.outcome != Outcome.RETURNED:
        fields["outcome"] = answer.outcome
    fields["message"] = answer.message
    text = output.listing(fields)
    if flight is None or len(flight.stops) < 2:
        return text
    return f"{text}\n\n{_stops(flight)}"


def _stops(flight: Flight) -> str:
    """A table of the first stops, as passed."""
    stops = flight.stops
    head = ("visit", "stop", "time", "length", "heading, deg", "compass, deg")
    rows = [
        (
            visit,
            stop.name,
            f"{stop.time:.1f}",
            f"{stop.length:.6g}",
            f"{math.degrees(stop.heading):z.1f}",
            f"{round(stop.compass, 1) % 360:.1f}",
        )
        for visit, stop in enumerate(stops[:_MOST_POINTS], 1)
    ]
    return output.table(head, rows) + _more("\nand", len(stops) - len(rows))


def _more(begin: str, count: int) -> str:
    """Words about items that a text leaves out.

    `begin` stands before the number, `count`. The text is empty if nothing is left out.
    """
    if count > 0:
        return f"{begin} {count} more: --json lists them"
    return ""


def _order(answer: Answer, names: Sequence[str]) -> str:
    """A tour's via points, in the path's order.

    A point has its name, or its number in the question, from 1. A name of several points has the
    number behind it. `names` are those of the points in the question's order.
    """
    order = answer.order or []
    names_by_place = dict(enumerate(names))
    texts = [plain(names_by_place.get(place, "")) for place in order]
    labels = []
    for text, place in zip(texts, order, strict=True):
        number = str(place + 1)
        label = text or number
        if text and texts.count(text) > 1:
            label = f"{text} ({number})"
        labels.append(label)
    return ", ".join(labels[:_MOST_POINTS]) + _more(", and", len(labels) - _MOST_POINTS)


def _given_order(answer: Answer, route: Answer | None) -> str:
    """The length of a tour in the given order.

    `route` is the answer for that order. The text compares its length with the tour's, and is empty
    if there is none.
    """
    if route is None or route.length is None or not answer.length:
        return ""
    if abs(route.length - answer.length) <= _SAME * answer.length:
        return "as short"
    more = 100 * (route.length / answer.length - 1)
    comparative = "shorter"
    if more > 0:
        comparative = "longer"
    text = f"{route.length:.12g}, {abs(more):.3g} % {comparative}"
    if route.proof != "proved":
        text += ", not proved to be the shortest"
    return text


def _word(answer: Answer) -> str:
    """The word of the path, with other shortest words."""
    no_word = "none"
    if answer.gap is not None:
        no_word = "none: the target is the start"
    text = short_word(answer.word or no_word)
    ties = [word for word in answer.tied_words if word != answer.reference_word]
    if ties:
        text += f"  (tied with {', '.join(ties)})"
    return text


def _proof(answer: Answer) -> str:
    """The proof of the answer, and what is unchecked.

    There may have been no time to check Pontryagin's conditions.
    """
    from dubins_study.study.kinds.table import kind_of

    unchecked = answer.gap is not None and answer.pmp_residual is None
    if unchecked and kind_of(answer.scenario, answer.branch).searched:
        return f"{answer.proof}; Pontryagin's conditions were not checked"
    return str(answer.proof)


def _optimum(answer: Answer) -> str:
    """The proven interval around the shortest length.

    Empty for a leg with a free final heading, whose shortest length is one number.
    """
    from dubins_study.study.kinds.table import kind_of

    low = answer.reference_low
    high = answer.reference_high
    by_interval = kind_of(answer.scenario, answer.branch).by_interval
    if low is None or high is None or not by_interval:
        return ""
    width = (high - low) / max(high, answer.scenario.radius)
    # as Python writes them: rounded further, they would be no bounds
    return f"in [{low!r}, {high!r}], relative width {width:.2g}"


def _shorter(answer: Answer) -> str:
    """The length of the check's path, if shorter."""
    from dubins_study.asking.attempt import shorter_answer

    shorter = shorter_answer(answer)
    if shorter is None or shorter.length is None:
        return ""
    return f"{shorter.length:.12g}, found by the check: --shortest takes it"


def _gap(answer: Answer) -> float | None:
    """The gap, not below 0 for proved paths.

    Rounding may put it below 0.
    """
    if answer.gap is not None and answer.gap < 0 and answer.proof == "proved":
        return 0.0
    return answer.gap


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.3g}"


def _segments(answer: Answer) -> str:
    """Turn and length of each piece of the path.

    An arc has its angle too, such as `L 2 (114.6 deg)`. Of many pieces only the first few are
    listed.
    """
    pieces = list(zip(answer.curvatures or (), answer.lengths or (), strict=True))
    if not pieces:
        return "none"
    texts = []
    for k, length in pieces[:_MOST_SEGMENTS]:
        text = f"{_letter(k)} {length:.6g}"
        if k:
            text += f" ({abs(math.degrees(k * length)):.4g} deg)"
        texts.append(text)
    return ", ".join(texts) + _more(", and", len(pieces) - len(texts))


def _milliseconds(seconds: float) -> str:
    if seconds < 1:
        return f"{seconds * 1e3:.3g} ms"
    return f"{seconds:.3g} s"


def _verdict(answer: Answer) -> str:
    """The verdict, and of a path that misses, why."""
    if answer.verdict != "misses" or answer.path is None:
        return str(answer.verdict)
    from dubins_study.study.judging.judge import miss_reason

    return f"{answer.verdict}: {miss_reason(answer.scenario, answer.path, answer.branch)}"
