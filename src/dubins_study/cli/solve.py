"""`dubins-study solve`: one scenario, solved and judged."""

from __future__ import annotations

import json
import math
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.cli.terminal import arguments, output
from dubins_study.cli.terminal.output import plain
from dubins_study.cli.terminal.points import read_points
from dubins_study.study.words import Outcome, short_word

if TYPE_CHECKING:
    from dubins_study.asking.attempt import Answer
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
_AFTER_FROM = "; --from takes X Y HEADING"  # two numbers too, and the third is the target's x


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
            metavar="SECONDS", parser=arguments.lone_number, help="seconds that the solve may take"
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

    target, via, names = _points(x, y, via, via_file)
    scenario = arguments.scenario_of(*target, start, radius, speed, via, final_heading)
    check_request(branch, time_limit, "--time-limit")
    for option, file in (("--plot", plot), ("--geojson", geojson)):
        if file is not None and file in (via_file, None if option == "--plot" else plot):
            raise arguments.CommandError(f"{option}: {file} is given twice; expected another file")
        if file is not None and (reason := unwritable(file)):  # before a solve that takes long
            raise arguments.CommandError(f"{option}: cannot write {file}: {reason}")
    if geojson is not None and geojson.suffix.lower() not in (".json", ".geojson"):
        raise arguments.CommandError(f"--geojson: {geojson}: expected a file .json or .geojson")
    if plot is not None:
        from dubins_study.report.path_plot import check_format

        check_format(plot)
    at_most = time_limit + min(time_limit, SEARCH_S)
    with output.solvers_to_stderr(), output.waiting("seconds, of at most", at_most):
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
    drawn = plot is None or _save(flown, plot, None)
    written = geojson is None or _save(flown, geojson, names)
    ended = answer.outcome == Outcome.RETURNED
    if not (ended and drawn and written) or (strict and answer.verdict != "optimal"):
        raise typer.Exit(1)


def _points(
    x: float | None, y: float | None, via: list[arguments.Point], file: FilePath | None
) -> tuple[arguments.Point, list[arguments.Point], list[str]]:
    """Target and via points, of which a file may have all; the names that the file gives them."""
    if file is None:
        if x is None or y is None:
            missing = "the target is missing" if x is None else "the target is a single number"
            raise arguments.CommandError(f"{missing}; expected X Y, or --via-file{_AFTER_FROM}")
        return arguments.Point(x, y), via, [""] * (len(via) + 1)
    if via:
        raise arguments.CommandError("--via and --via-file are given; expected one of them")
    points, names = read_points(file)
    if x is None:
        return points[-1], points[:-1], names
    if y is None:
        message = f"the target is a single number; expected X Y, or neither{_AFTER_FROM}"
        raise arguments.CommandError(message)
    return arguments.Point(x, y), points, [*names, ""]


def _save(answer: Answer, file: FilePath, names: Sequence[str] | None) -> bool:
    """Draw an answer's path, or write it with names as GeoJSON; False, and why, without a path."""
    if answer.length is None or answer.path is None:
        reason = "there is no path" if answer.path is None else "the path is not finite"
        print(f"dubins-study: {file} is not written: {reason}", file=sys.stderr)
        return False
    if names is None:
        from dubins_study.report.path_plot import plot_path

        plot_path(answer, file)
        return True
    features = answer_geojson(answer, answer.path, names)
    try:
        file.write_text(json.dumps(features, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        message = f"--geojson: cannot write {file}: {error.strerror}"
        raise arguments.CommandError(message) from None
    return True


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
    from dubins_study.study.kinds.table import kind_of

    lines = [
        _line("verdict", _verdict(answer)),
        _line("claim", f"{answer.claim}  ({answer.solver})"),
    ]
    if answer.presolved and answer.verdict == "none exists":
        lines.append(_line("presolve", "answered, and the engine was not asked"))
    proof = str(answer.proof)
    unchecked = answer.gap is not None and answer.pmp_residual is None
    if kind_of(answer.scenario, answer.branch).searched and unchecked:
        proof += "; Pontryagin's conditions were not checked in time"
    lines.append(_line("proof", proof))
    if answer.length is not None:
        ties = [word for word in answer.tied_words if word != answer.reference_word]
        tied = f"  (tied with {', '.join(ties)})" if ties else ""
        none = "none" if answer.gap is None else "none: the target is the start"
        lines = [
            _line("word", f"{short_word(answer.word or none)}{tied}"),
            _line("length", f"{answer.length:.12g}"),
            _line("travel time", f"{answer.travel_time:.12g}"),
            _line("segments", _segments(answer)),
            *_optimum(answer),
            *_shorter(answer),
            *lines,
            _line("gap", "–" if answer.gap is None else format(answer.gap, ".3g")),
            _line("miss", "–" if answer.miss is None else format(answer.miss, ".3g")),
        ]
    if answer.margin is not None:
        circle = f"{answer.margin:.3g} R from the nearer turning circle"
        lines.append(_line("region", f"{answer.region}, {circle}"))
    if answer.solve_s is not None:
        built = f", after {_milliseconds(answer.build_s or 0.0)} to build"
        lines.append(_line("solve time", f"{_milliseconds(answer.solve_s)}{built}"))
    elif answer.wall_s is not None:  # it was not solved
        lines.append(_line("ended after", _milliseconds(answer.wall_s)))
    if answer.false_claim:
        lines.append("false claim: the claim is stronger than the verdict")
    if answer.false_bound:
        lines.append("false bound: the solver's lower bound lies above the shortest length")
    if answer.outcome != Outcome.RETURNED:
        lines.append(_line("outcome", answer.outcome))
    if answer.message:
        lines.append(_line("message", plain(answer.message)))
    return "\n".join(lines)


def _optimum(answer: Answer) -> list[str]:
    """The proven interval around the shortest length of a route, or of a leg to a pose.

    Of a leg these are several intervals where the length jumps within the rounding of the data.
    """
    from dubins_study.study.kinds.table import kind_of, reference_of

    kind = kind_of(answer.scenario, answer.branch)
    low, high = answer.reference_low, answer.reference_high
    if not kind.by_interval or low is None or high is None:
        return []
    parts: tuple[tuple[float, float], ...] = ((low, high),)
    if not kind.searched:
        parts = reference_of(answer.scenario, answer.branch).enclosure.parts
    # as Python writes them: rounded further, they would be no bounds
    text = " or ".join(f"[{begin!r}, {end!r}]" for begin, end in parts)
    widest = max(end - begin for begin, end in parts) / max(high, answer.scenario.radius)
    return [_line("optimum", f"in {text}, relative width {widest:.2g}")]


def _shorter(answer: Answer) -> list[str]:
    """The length of the check's path where it is shorter than the answer."""
    from dubins_study.asking.attempt import shorter_answer

    found = shorter_answer(answer)
    if found is None or found.length is None:
        return []
    return [_line("shorter", f"{found.length:.12g}, found by the check: --shortest takes it")]


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


def _line(name: str, value: str) -> str:
    """A name and its value, which goes on below itself where the terminal ends."""
    width = max(output.terminal_width() or 10**6, 40)  # without a terminal, a value is one line
    return textwrap.fill(f"{name:<12}{value}", width, subsequent_indent=" " * 12, tabsize=1)


def _verdict(answer: Answer) -> str:
    """The verdict, and of a path that misses, why."""
    if answer.verdict != "misses" or answer.path is None:
        return str(answer.verdict)
    from dubins_study.study.judging.judge import miss_reason

    return f"{answer.verdict}: {miss_reason(answer.scenario, answer.path, answer.branch)}"
