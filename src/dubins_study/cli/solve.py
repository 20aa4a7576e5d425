"""`dubins-study solve`: one scenario, solved and judged."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import typer

from dubins_study.cli.terminal import arguments, output
from dubins_study.cli.terminal.output import plain
from dubins_study.study.words import Order, Outcome, short_word

if TYPE_CHECKING:
    from dubins_study.asking.attempt import Answer
    from dubins_study.missions.mission import MissionPoint
    from dubins_study.study.path import Path
    from dubins_study.study.scenario import Scenario

# Fields of an answer in the JSON object, which also has the question's, `given_order_length`,
# `segments` and `tied_words`.
_JSON = (
    *("word", "length", "travel_time", "gap", "verdict", "claim", "outcome", "solver", "branch"),
    *("presolved", "miss", "region", "margin", "reference", "reference_word"),
    *("curvature_excess", "claimed_length", "lower_bound", "false_claim", "wrong_basin", "proof"),
    *("reference_low", "reference_high", "pmp_residual", "cut_margin", "false_bound"),
    *("native_status", "message", "build_s", "solve_s", "wall_s", "visits", "order"),
)

# Fields of an answer that the path in a GeoJSON file has beside its own.
_GEOJSON = (
    *("word", "travel_time", "solver", "claim", "verdict", "proof", "gap", "miss"),
    *("reference_low", "reference_high"),
)

_MOST_SEGMENTS = 4  # of a path of many pieces, in the text
_MOST_POINTS = 24  # of an order
_SAME = 1e-8  # relative; two searches to 1e-9 each
# Share of the limit for a tour's points in their given order: a good path of thousands takes a
# second, a proof that it is the shortest is for `--order given`.
_COMPARED = 0.1


def solve(
    x: arguments.MaybeX = None,
    y: arguments.MaybeY = None,
    start: arguments.StartPose = ("0", "0", "0"),
    via: arguments.Via = [],  # noqa: B006  typer makes a new one
    via_file: arguments.ViaFile = None,
    via_headings: arguments.ViaHeadings = [],  # noqa: B006
    order: arguments.OrderOfVia = "given",
    closed: arguments.Closed = False,
    final_heading: arguments.FinalHeading = None,
    radius: arguments.Radius = 1,
    speed: arguments.Speed = 1,
    solver: arguments.Spec = "analytic",
    branch: arguments.Branch = "best",
    profile: arguments.Profile = "default",
    time_limit: arguments.TimeLimit = 60.0,
    as_json: arguments.Json = False,
    plot: arguments.Plot = None,
    geojson: arguments.Geojson = None,
    shortest: arguments.Shortest = False,
    strict: arguments.Strict = False,
) -> None:
    """Solve one scenario and judge the answer."""
    from dubins_study.asking.attempt import check_request, shorter_answer
    from dubins_study.study.scenario import checked_order

    no_target = closed or (checked_order(order) is Order.FREE and x is None)
    points = _with_headings(_points(x, y, via, via_file, no_target), via_headings, no_target)
    names = [each.name for each in points]
    scenario = arguments.scenario_of(
        start=start,
        radius=radius,
        speed=speed,
        order=order,
        closed=closed,
        **_stops(points, final_heading, no_target),
    )
    check_request(branch, time_limit, "--time-limit")
    _check_files(plot, geojson)
    answer, in_given_order = _answers(scenario, solver, branch, profile, time_limit)
    _print(answer, names, in_given_order, as_json)
    flown = answer
    if shortest:
        flown = shorter_answer(answer) or answer
    complete = _write_files(flown, names, plot, geojson)
    ended = complete and answer.outcome == Outcome.RETURNED
    if not ended or (strict and answer.verdict != "optimal"):
        raise typer.Exit(1)


def _stops(
    points: list[MissionPoint], final_heading: str | None, no_target: bool
) -> dict[str, Any]:
    """The fields of a scenario that say where it passes and ends."""
    via = points if no_target else points[:-1]
    fields: dict[str, Any] = {
        "via": [(each.x, each.y, _in_radians(each.heading)) for each in via],
        "x": None,
        "y": None,
        "final_heading": final_heading,
    }
    if no_target:
        return fields
    last = points[-1]
    if last.heading is not None:
        if final_heading is not None:
            message = "the last point has a heading, and --final-heading is given"
            raise arguments.CommandError(f"{message}; expected one of them")
        fields["final_heading"] = _in_radians(last.heading)
    return fields | {"x": last.x, "y": last.y}


def _check_files(plot: FilePath | None, geojson: FilePath | None) -> None:
    """Refuse files that cannot be written, before a solve that takes long."""
    from dubins_study.study.values import unwritable

    for option, file in (("--plot", plot), ("--geojson", geojson)):
        if file is not None and (reason := unwritable(file)):
            raise arguments.CommandError(f"{option}: cannot write {file}: {reason}")
    if geojson is not None and geojson.suffix.lower() not in (".json", ".geojson"):
        raise arguments.CommandError(f"--geojson: {geojson}: expected a file .json or .geojson")
    if plot is not None:
        from dubins_study.report.path_plot import check_format

        check_format(plot)


def _answers(
    scenario: Scenario, solver: str, branch: str, profile: str, limit: float
) -> tuple[Answer, Answer | None]:
    """The answer, and of a tour that of its points in their given order."""
    from dubins_study.experiments.solve import solve as ask
    from dubins_study.study.tolerances import SEARCH_S

    compared_s = _COMPARED * limit if scenario.order is Order.FREE else 0.0
    at_most = limit + min(limit, SEARCH_S) + compared_s
    with output.solvers_to_stderr(), output.steps(f"solving, at most {at_most:g} s"):
        answer = ask(scenario, solver, branch, profile=profile, limit=limit, isolated=True)
        if answer.order is None:
            return answer, None
        return answer, ask(_route_of(scenario), limit=compared_s, isolated=True)


def _print(
    answer: Answer, names: Sequence[str], in_given_order: Answer | None, as_json: bool
) -> None:
    """Print an answer; refuse the request of one that no solver was asked for."""
    refused = answer.outcome in (Outcome.UNAVAILABLE, Outcome.UNSUPPORTED)
    if as_json or not refused:  # before the drawing, which may fail
        text = answer_json if as_json else answer_text
        print(text(answer, names, in_given_order), flush=True)
    if refused:
        message = f"solver {answer.solver!r} is {answer.outcome}: {plain(answer.message)}"
        raise arguments.CommandError(message)


def _write_files(
    flown: Answer, names: Sequence[str], plot: FilePath | None, geojson: FilePath | None
) -> bool:
    """Draw and write a path where files are given; whether none is left out."""
    if flown.length is not None and flown.path is not None:
        if plot is not None:
            from dubins_study.report.path_plot import plot_path

            plot_path(flown, plot, names=names)
        if geojson is not None:
            _write_geojson(answer_geojson(flown, flown.path, names), geojson)
        return True
    files = [file for file in (plot, geojson) if file is not None]
    for file in files:
        print(f"dubins-study: {file} is not written: there is no finite path", file=sys.stderr)
    return not files


def _in_radians(heading: float | None) -> str | None:
    """A heading as a text with its unit, so that nobody takes it for degrees."""
    return None if heading is None else f"{heading!r}rad"


def _points(
    x: float | None,
    y: float | None,
    via: list[arguments.Point],
    file: FilePath | None,
    no_target: bool,
) -> list[MissionPoint]:
    """Via points and, unless there is none, the target, of which a file may have all."""
    from dubins_study.missions.mission import MissionPoint
    from dubins_study.missions.table import read_points

    if via and file is not None:
        raise arguments.CommandError("--via and --via-file are given; expected one of them")
    if x is not None and y is not None and no_target:
        raise arguments.CommandError("X Y and --closed are given; a closed path ends at its start")
    if (x is None and file is None and not no_target) or (x is not None and y is None):
        # of `--from 0 0 1 2` the third number is the heading
        message = "the target is missing, or a single number; expected X Y, or --via-file"
        raise arguments.CommandError(f"{message}; --from takes X Y HEADING")
    points = [MissionPoint(*each) for each in via] if file is None else read_points(file)
    if x is not None and y is not None:
        points.append(MissionPoint(x, y))
    return points


def _with_headings(
    points: list[MissionPoint], headings: list[arguments.StopHeading], no_target: bool
) -> list[MissionPoint]:
    """The points with the headings that are given at some of the via points."""
    from dubins_study.study.angle import parse_angle

    count = len(points) if no_target else len(points) - 1
    found = list(points)
    for place, text in headings:
        if not 1 <= place <= count:
            expected = f"expected one from 1 to {count}" if count else "there is no via point"
            raise arguments.CommandError(f"--via-heading: place {place}; {expected}")
        if found[place - 1].heading is not None:
            message = f"via point {place} has two headings; expected one"
            raise arguments.CommandError(f"--via-heading: {message}")
        if text != "free":
            found[place - 1] = found[place - 1]._replace(heading=parse_angle(text))
    return found


def _route_of(scenario: Scenario) -> Scenario:
    """A tour's question with its order given: where it ends at any point, at the last one."""
    changed: dict[str, Any] = {"order": "given"}
    if scenario.target is None:
        x, y, heading = scenario.stops[-1]
        changed |= {"via": scenario.via[:-1], "target_x": x, "target_y": y}
        changed |= {"final_heading": heading}
    return replace(scenario, **changed)


def _write_geojson(features: dict[str, Any], file: FilePath) -> None:
    try:
        file.write_text(json.dumps(features, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        message = f"--geojson: cannot write {file}: {error.strerror}"
        raise arguments.CommandError(message) from None


def answer_geojson(answer: Answer, path: Path, names: Sequence[str]) -> dict[str, Any]:
    """A FeatureCollection: the path, then its via points and the target, with a name for each.

    A point has the path's heading there, or null if the path is not known to pass all points.
    """
    properties = {"kind": "path"} | {name: getattr(answer, name) for name in _GEOJSON}
    features = [path.to_geojson(radius=answer.scenario.radius, **properties)]
    scenario = answer.scenario
    via, order = len(scenario.via), answer.order or range(len(scenario.via))
    # where the path is at each via point, in the order of the question; then at its end
    along: list[float] = []
    if len(answer.visits or ()) == via:
        along = [at for _, at in sorted(zip(order, answer.visits or (), strict=True))]
    at = [*along, path.length]
    turned = [math.remainder(heading, math.tau) for heading in path.at(at)[:, 2]]
    places = dict(zip(order, range(1, via + 1), strict=True))
    for index, (x, y, _) in enumerate(scenario.stops):
        is_via = index < via
        shown = {
            "kind": "via" if is_via else "target",
            "index": index + 1,
            "name": (names[index] if index < len(names) else "") or None,
            "heading_rad": turned[index] if len(at) > via else None,
        }
        if answer.order is not None:
            shown["visit"] = places[index] if is_via else None
        geometry = {"type": "Point", "coordinates": [x, y]}
        features.append({"type": "Feature", "geometry": geometry, "properties": shown})
    return {"type": "FeatureCollection", "features": features}


def answer_json(
    answer: Answer, names: Sequence[str] = (), in_given_order: Answer | None = None
) -> str:
    """One object: the answer, its segments, and the question."""
    pieces = zip(answer.curvatures or (), answer.lengths or (), strict=True)
    fields: dict[str, Any] = {name: getattr(answer, name) for name in _JSON}
    fields["via"] = [list(point) for point in answer.scenario.via]
    fields["names"] = list(names)
    fields["final_heading"] = answer.scenario.final_heading
    fields["closed"] = answer.scenario.closed
    fields["gap"] = _gap(answer)
    fields["start_heading"] = None
    if answer.path is not None:
        fields["start_heading"] = math.remainder(answer.path.start.heading, math.tau)
    fields["given_order_length"] = None if in_given_order is None else in_given_order.length
    fields["given_order_proof"] = None if in_given_order is None else in_given_order.proof
    fields["segments"] = [
        {"turn": _letter(k), "length": length, "curvature": k} for k, length in pieces
    ]
    fields["tied_words"] = list(answer.tied_words)
    return json.dumps(fields, indent=2, allow_nan=False)


def _letter(curvature: float) -> str:
    return "L" if curvature > 0 else "R" if curvature < 0 else "S"


def answer_text(
    answer: Answer, names: Sequence[str] = (), in_given_order: Answer | None = None
) -> str:
    """The answer as a few lines for the terminal.

    Args:
        names: of the via points, some of which may be empty.
        in_given_order: the answer to a tour's points in the order in which they are given.
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
    return output.listing(fields)


def _order(answer: Answer, names: Sequence[str]) -> str:
    """The via points of a tour in the order in which the path passes them: names, or numbers."""
    order = answer.order or []
    texts = [plain(names[place]) if place < len(names) else "" for place in order]
    shown = []
    for text, place in zip(texts, order, strict=True):
        number = str(place + 1)
        alone = text if texts.count(text) == 1 else f"{text} ({number})"
        shown.append(alone if text else number)
    more = len(shown) - _MOST_POINTS
    rest = f", and {more} more: --json lists them" if more > 0 else ""
    return ", ".join(shown[:_MOST_POINTS]) + rest


def _given_order(answer: Answer, route: Answer | None) -> str:
    """What a tour's points would have cost in the order in which they are given."""
    if route is None or route.length is None or not answer.length:
        return ""
    if abs(route.length - answer.length) <= _SAME * answer.length:
        return "as short"
    more = 100 * (route.length / answer.length - 1)
    than = "longer" if more > 0 else "shorter"
    proved = "" if route.proof == "proved" else ", not proved to be the shortest"
    return f"{route.length:.12g}, {abs(more):.3g} % {than}{proved}"


def _word(answer: Answer) -> str:
    """The word of the path, and the words that are as short."""
    none = "none" if answer.gap is None else "none: the target is the start"
    ties = [word for word in answer.tied_words if word != answer.reference_word]
    tied = f"  (tied with {', '.join(ties)})" if ties else ""
    return f"{short_word(answer.word or none)}{tied}"


def _proof(answer: Answer) -> str:
    """What is proved of the answer, and what there was no time to check."""
    from dubins_study.study.kinds.table import kind_of

    unchecked = answer.gap is not None and answer.pmp_residual is None
    if unchecked and kind_of(answer.scenario, answer.branch).searched:
        return f"{answer.proof}; Pontryagin's conditions were not checked"
    return str(answer.proof)


def _optimum(answer: Answer) -> str:
    """The proven interval around the shortest length of a route, or of a leg to a pose."""
    from dubins_study.study.kinds.table import kind_of

    low, high = answer.reference_low, answer.reference_high
    by_interval = kind_of(answer.scenario, answer.branch).by_interval
    if low is None or high is None or not by_interval:
        return ""
    width = (high - low) / max(high, answer.scenario.radius)
    # as Python writes them: rounded further, they would be no bounds
    return f"in [{low!r}, {high!r}], relative width {width:.2g}"


def _shorter(answer: Answer) -> str:
    """The length of the check's path where it is shorter than the answer."""
    from dubins_study.asking.attempt import shorter_answer

    found = shorter_answer(answer)
    if found is None or found.length is None:
        return ""
    return f"{found.length:.12g}, found by the check: --shortest takes it"


def _gap(answer: Answer) -> float | None:
    """The gap, none below 0 of a proved path: rounding may put it there."""
    gap = answer.gap
    return 0.0 if gap is not None and gap < 0 and answer.proof == "proved" else gap


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _segments(answer: Answer) -> str:
    """Turn and length of each piece of the path, an arc with its angle; the first few of many."""
    pieces = list(zip(answer.curvatures or (), answer.lengths or (), strict=True))
    if not pieces:
        return "none"
    texts = [
        f"{_letter(k)} {length:.6g}" + (f" ({abs(math.degrees(k * length)):.4g} deg)" if k else "")
        for k, length in pieces[:_MOST_SEGMENTS]
    ]
    more = len(pieces) - len(texts)
    return ", ".join(texts) + (f", and {more} more: --json lists them" if more else "")


def _milliseconds(seconds: float) -> str:
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def _verdict(answer: Answer) -> str:
    """The verdict, and of a path that misses, why."""
    if answer.verdict != "misses" or answer.path is None:
        return str(answer.verdict)
    from dubins_study.study.judging.judge import miss_reason

    return f"{answer.verdict}: {miss_reason(answer.scenario, answer.path, answer.branch)}"
