"""`dubins-study solve`: one scenario, solved and judged."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.cli.terminal import arguments, output
from dubins_study.cli.terminal.output import plain
from dubins_study.study.words import Outcome, short_word

if TYPE_CHECKING:
    from dubins_study.asking.attempt import Answer
    from dubins_study.experiments.definition.point_file import NamedPoint
    from dubins_study.study.path import Path

# Fields of an answer in the JSON object, which also has `via`, `final_heading`, `segments` and
# `tied_words`.
_JSON = (
    *("word", "length", "travel_time", "gap", "verdict", "claim", "outcome", "solver", "branch"),
    *("presolved", "miss", "region", "margin", "reference", "reference_word"),
    *("curvature_excess", "claimed_length", "lower_bound", "false_claim", "wrong_basin", "proof"),
    *("reference_low", "reference_high", "pmp_residual", "cut_margin", "false_bound"),
    *("native_status", "message", "build_s", "solve_s", "wall_s"),
)

# Fields of an answer that the path in a GeoJSON file has beside its own.
_GEOJSON = (
    *("word", "travel_time", "solver", "claim", "verdict", "proof", "gap", "miss"),
    *("reference_low", "reference_high"),
)

_MOST_SEGMENTS = 4  # of a path of many pieces, in the text


def solve(
    x: arguments.MaybeX = None,
    y: arguments.MaybeY = None,
    start: arguments.StartPose = ("0", "0", "0"),
    via: arguments.Via = [],  # noqa: B006  typer makes a new one
    via_file: arguments.ViaFile = None,
    final_heading: arguments.FinalHeading = None,
    radius: arguments.Radius = 1,
    speed: arguments.Speed = 1,
    solver: arguments.Spec = "analytic",
    branch: arguments.Branch = "best",
    profile: arguments.Profile = "default",
    time_limit: Annotated[
        float,
        typer.Option(
            metavar="SECONDS", parser=arguments.number, help="seconds that the solve may take"
        ),
    ] = 60.0,
    as_json: arguments.Json = False,
    plot: Annotated[
        FilePath | None, typer.Option(metavar="FILE", help="draw the path: .svg, .pdf or .png")
    ] = None,
    geojson: Annotated[
        FilePath | None,
        typer.Option(metavar="FILE", help="write path and points as GeoJSON, in their x and y"),
    ] = None,
    shortest: Annotated[
        bool,
        typer.Option(
            "--shortest", help="draw and write the check's path where it is shorter than the answer"
        ),
    ] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="exit code 1 unless the verdict is optimal")
    ] = False,
) -> None:
    """Solve one scenario and judge the answer."""
    from dubins_study.asking.attempt import check_request, shorter_answer
    from dubins_study.experiments.solve import solve as ask
    from dubins_study.study.tolerances import SEARCH_S
    from dubins_study.study.values import unwritable

    points = _points(x, y, via, via_file)
    target = points[-1]
    passed = [arguments.Point(each.x, each.y) for each in points[:-1]]
    scenario = arguments.scenario_of(
        target.x, target.y, start, radius, speed, via=passed, final_heading=final_heading
    )
    check_request(branch, time_limit, "--time-limit")
    for option, file in (("--plot", plot), ("--geojson", geojson)):
        if file is not None and (reason := unwritable(file)):  # before a solve that takes long
            raise arguments.CommandError(f"{option}: cannot write {file}: {reason}")
    if geojson is not None and geojson.suffix.lower() not in (".json", ".geojson"):
        raise arguments.CommandError(f"--geojson: {geojson}: expected a file .json or .geojson")
    if plot is not None:
        from dubins_study.report.path_plot import check_format

        check_format(plot)
    at_most = time_limit + min(time_limit, SEARCH_S)
    with output.solvers_to_stderr(), output.steps(f"solving, at most {at_most:g} s"):
        answer = ask(scenario, solver, branch, profile=profile, limit=time_limit, isolated=True)
    refused = answer.outcome in (Outcome.UNAVAILABLE, Outcome.UNSUPPORTED)
    if as_json or not refused:  # before the drawing, which may fail
        print(answer_json(answer) if as_json else answer_text(answer), flush=True)
    if refused:
        message = f"solver {answer.solver!r} is {answer.outcome}: {plain(answer.message)}"
        raise arguments.CommandError(message)
    flown = answer
    if shortest:
        flown = shorter_answer(answer) or answer
    written = [file for file in (plot, geojson) if file is not None]
    drivable = flown.length is not None and flown.path is not None
    if drivable:
        _draw(flown, plot)
        _write_geojson(flown, geojson, [each.name for each in points])
    for file in () if drivable else written:
        print(f"dubins-study: {file} is not written: there is no finite path", file=sys.stderr)
    ended = answer.outcome == Outcome.RETURNED and (drivable or not written)
    if not ended or (strict and answer.verdict != "optimal"):
        raise typer.Exit(1)


def _points(
    x: float | None, y: float | None, via: list[arguments.Point], file: FilePath | None
) -> list[NamedPoint]:
    """Via points and the target, of which a file may have all."""
    from dubins_study.experiments.definition.point_file import NamedPoint, read_points

    if via and file is not None:
        raise arguments.CommandError("--via and --via-file are given; expected one of them")
    if (x is None and file is None) or (x is not None and y is None):
        # of `--from 0 0 1 2` the third number is the heading
        message = "the target is missing, or a single number; expected X Y, or --via-file"
        raise arguments.CommandError(f"{message}; --from takes X Y HEADING")
    points = [NamedPoint(*each, "") for each in via] if file is None else read_points(file)
    if x is not None and y is not None:
        points.append(NamedPoint(x, y, ""))
    return points


def _draw(answer: Answer, file: FilePath | None) -> None:
    """Draw an answer's path, if a file is given."""
    if file is not None:
        from dubins_study.report.path_plot import plot_path

        plot_path(answer, file)


def _write_geojson(answer: Answer, file: FilePath | None, names: Sequence[str]) -> None:
    """Write an answer's path and its points, with their names, if a file is given."""
    if file is None or answer.path is None:
        return
    features = answer_geojson(answer, answer.path, names)
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
    points = answer.scenario.points[1:].tolist()
    at = [*(answer.visits or ()), path.length]
    turned = [math.remainder(heading, math.tau) for heading in path.at(at)[:, 2]]
    headings = turned if len(at) == len(points) else [None] * len(points)
    for index, (name, point, heading) in enumerate(zip(names, points, headings, strict=True), 1):
        kind = "target" if index == len(points) else "via"
        shown = {"kind": kind, "index": index, "name": name or None, "heading_rad": heading}
        geometry = {"type": "Point", "coordinates": point}
        features.append({"type": "Feature", "geometry": geometry, "properties": shown})
    return {"type": "FeatureCollection", "features": features}


def answer_json(answer: Answer) -> str:
    """One object: the answer, its segments, and the question."""
    pieces = zip(answer.curvatures or (), answer.lengths or (), strict=True)
    fields: dict[str, Any] = {name: getattr(answer, name) for name in _JSON}
    fields["via"] = [list(point) for point in answer.scenario.via]
    fields["final_heading"] = answer.scenario.final_heading
    fields["segments"] = [
        {"turn": _letter(k), "length": length, "curvature": k} for k, length in pieces
    ]
    fields["tied_words"] = list(answer.tied_words)
    return json.dumps(fields, indent=2, allow_nan=False)


def _letter(curvature: float) -> str:
    return "L" if curvature > 0 else "R" if curvature < 0 else "S"


def answer_text(answer: Answer) -> str:
    """The answer as a few lines for the terminal."""
    fields: dict[str, str] = {}
    if answer.length is not None:
        fields["word"] = _word(answer)
        fields["length"] = f"{answer.length:.12g}"
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
        fields["gap"] = _number(answer.gap)
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
        return f"{answer.proof}; Pontryagin's conditions were not checked in time"
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
