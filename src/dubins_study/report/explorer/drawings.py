"""Two drawings of the problem itself: its paths LS and RS, and the map of shortest words.

Both have their own paper and are read on light and dark pages; line styles, hatching and labels say
what colours say.
"""

from __future__ import annotations

import math
from pathlib import Path as FilePath

from dubins_study.report.explorer.canvas import Canvas, Point
from dubins_study.study.closed_form.shortest import shortest, shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario

PROBLEM_ALT = (
    "A vehicle's start pose with its two turning circles of radius R, and two paths to a target: "
    "RS, a right turn and a straight, is shortest; LS, a left turn and a straight, goes once around"
)
MAP_ALT = (
    "Targets by shortest word, for a vehicle in the middle that heads right: LS to its left and RS "
    "to its right, but RL inside the left turning circle and LR inside the right one; S straight "
    "ahead; straight behind LS and RS tie"
)
INK, MUTED, PAPER = "#1f2328", "#57606a", "#ffffff"
LEFT, RIGHT = "#0060a0", "#b84a00"  # turns left first, turns right first
# Fill and hatching of each word's region; the fills differ in grey too.
FILLS = {"LS": "#e6f0f8", "RS": "#fcf1e0", "RL": "#b9d5ea", "LR": "#f2d19c"}

_STYLE = f"""
text{{font:14px system-ui,"Segoe UI",Helvetica,Arial,sans-serif;fill:{INK};
paint-order:stroke;stroke:{PAPER};stroke-width:3px;stroke-linejoin:round}}
text.name{{font-weight:700;font-size:16px}} text.small{{font-size:12px;fill:{MUTED}}}
text.left{{fill:{LEFT}}} text.right{{fill:{RIGHT}}}
path,polyline{{fill:none;stroke-linejoin:round;stroke-linecap:round}}
.left{{stroke:{LEFT}}} .right{{stroke:{RIGHT}}} text.left,text.right{{stroke:{PAPER}}}
.best{{stroke-width:4}} .other{{stroke-width:2.5;stroke-dasharray:9 6}}
.thin{{stroke-width:2;}} .circle{{fill:none;stroke:{MUTED};stroke-width:1.2;stroke-dasharray:4 4}}
.front{{fill:none;stroke:{INK};stroke-width:3.5}} .rear{{fill:none;stroke:{INK};stroke-width:1}}
.rule{{stroke:{MUTED};stroke-width:1.2}} .tie{{stroke:{INK};stroke-width:1.2;stroke-dasharray:5 4}}
.ink{{stroke:{INK};stroke-width:2.5}} .head{{fill:{INK};stroke:none}} .dot{{fill:{INK};stroke:none}}
.target{{fill:{PAPER};stroke:{INK};stroke-width:2.5}}
"""


def problem_svg() -> str:
    """Start pose, both turning circles, the target, and the paths LS and RS to it."""
    scenario = Scenario(0, 0, "70deg", 3.7, -0.15, 1)
    canvas = Canvas((-2.2, -1.5), (7.0, 3.05), 100, PROBLEM_ALT, _STYLE)
    canvas.paper(PAPER)
    left, right = (_from_start(scenario, 0, side) for side in (1, -1))
    for centre in (left, right):
        canvas.circle(centre, 1, "circle")
        canvas.dot(centre, 3, "dot")
    edge = right[0] + math.cos(math.radians(50)), right[1] - math.sin(math.radians(50))
    canvas.line(right, edge, "rule")
    for branch, style in (("LS", "left other"), ("RS", "right best")):
        canvas.path(_path(scenario, branch), style)
    canvas.arrow((0, 0), scenario.heading, 62, "ink")
    canvas.dot((0, 0), 5, "dot")
    target = scenario.target_x, scenario.target_y
    canvas.dot(target, 7, "target")
    _problem_texts(canvas, left, right, target)
    for branch, place in (("RS", (1.75, 0.78)), ("LS", (2.05, -0.98))):
        turn, style = ("right", "best") if branch == "RS" else ("left", "other")
        length = f"{turn}, then straight: {_length(scenario, branch):.2f} R"
        canvas.text(place, branch, f"name {turn}")
        canvas.text(place, length + (", shortest" if style == "best" else ""), "plain", (30, 0))
    return canvas.svg()


def _problem_texts(canvas: Canvas, left: Point, right: Point, target: Point) -> None:
    canvas.text((0, 0), "start", "plain", (-14, 2), "end")
    canvas.text((0, 0), "place and heading", "small", (-14, 17), "end")
    canvas.text(left, "left turning circle", "small", (0, -14), "middle")
    canvas.text(right, "right turning circle", "small", (-18, 50), "middle")
    canvas.text(right, "R", "name", (46, 42))
    canvas.text(target, "target", "plain", (0, 26), "middle")
    canvas.text(target, "to arrive with any heading", "small", (0, 42), "middle")


def words_svg() -> str:
    """Which word is shortest where, with a path of each; the vehicle is at the origin."""
    canvas = Canvas((-3.6, -2.45), (7.2, 4.9), 100, MAP_ALT, _STYLE + _fills(), _hatches())
    canvas.paper(PAPER)
    for word, edge in (("LS", 2.45), ("RS", -2.45)):
        for style in (word, f"over-{word}"):
            canvas.polygon([(-3.6, 0), (3.6, 0), (3.6, edge), (-3.6, edge)], style)
    for word, side in (("RL", 1), ("LR", -1)):
        for style in (word, f"over-{word}", "rear"):
            canvas.circle((0, side), 1, style)
        canvas.path(Path(Pose(0, 0, 0), [side], [math.pi]), "front")
    canvas.line((0, 0), (3.6, 0), "rule")
    canvas.line((-3.6, 0), (0, 0), "tie")
    for word, target in _EXAMPLES.items():
        scenario = Scenario(target_x=target[0], target_y=target[1])
        canvas.path(_path(scenario, "best"), f"{'left' if word[0] == 'L' else 'right'} thin")
        canvas.dot(target, 4.5, "target")
    canvas.arrow((0, 0), 0, 48, "ink")
    canvas.dot((0, 0), 5, "dot")
    _map_texts(canvas)
    return canvas.svg()


def _fills() -> str:
    regions = (f".{word}{{fill:{fill}}}" for word, fill in FILLS.items())
    return "".join((*regions, *(f".over-{word}{{fill:url(#over-{word})}}" for word in FILLS)))


def _hatches() -> str:
    """A pattern for each word's region but LS, which has none."""
    frame = 'width="10" height="10" patternUnits="userSpaceOnUse"'
    marks = {
        "LS": "",
        "RS": f'<circle cx="5" cy="5" r="1" fill="{MUTED}"/>',
        "RL": f'<path d="M-2 2L2 -2M0 10L10 0M8 12L12 8" stroke="{MUTED}" stroke-width=".8"/>',
        "LR": f'<path d="M-2 8L2 12M0 0L10 10M8 -2L12 2" stroke="{MUTED}" stroke-width=".8"/>',
    }
    return "".join(
        f'<pattern id="over-{word}" {frame}>{mark}</pattern>' for word, mark in marks.items()
    )


# a target of each word
_EXAMPLES: dict[str, Point] = {
    "LS": (2.3, 1.6),
    "RS": (2.6, -1.9),
    "RL": (0.15, 1.35),
    "LR": (-0.35, -0.75),
}


def _map_texts(canvas: Canvas) -> None:
    for word, place in {"LS": (-2.6, 1.3), "RS": (-2.6, -1.4)}.items():
        turn = "left" if word == "LS" else "right"
        canvas.text(place, word, "name", (0, 0), "middle")
        canvas.text(place, f"{turn}, then straight", "plain", (0, 19), "middle")
    for word, place in {"RL": (-0.45, 1.15), "LR": (0.42, -1.4)}.items():
        canvas.text(place, word, "name", (0, 0), "middle")
    canvas.text((2.5, 0), "S: straight ahead", "plain", (0, -8), "middle")
    canvas.text((-2.5, 0), "LS and RS tie", "plain", (0, -8), "middle")
    canvas.text((0, 2), "heavy: here the length jumps by up to 2πR", "small", (14, -12))
    canvas.text((0, 0), "start", "plain", (-10, -8), "end")


def _from_start(scenario: Scenario, forward: float, left: float) -> Point:
    """A point of the plane from the vehicle's frame, in radii."""
    cos, sin = math.cos(scenario.heading), math.sin(scenario.heading)
    return forward * cos - left * sin, forward * sin + left * cos


def _path(scenario: Scenario, branch: str) -> Path:
    path = shortest_path(scenario, branch)
    assert path is not None, f"{branch} reaches every target outside the circles"
    return path


def _length(scenario: Scenario, branch: str) -> float:
    optimum = shortest(scenario, branch)
    assert optimum is not None, f"{branch} reaches every target outside the circles"
    return optimum.total


def write_drawings(folder: FilePath) -> list[FilePath]:
    """Write `problem.svg` and `words.svg`; returns their paths."""
    files = []
    for name, draw in (("problem", problem_svg), ("words", words_svg)):
        file = folder / f"{name}.svg"
        file.write_text(draw(), encoding="utf-8", newline="\n")
        files.append(file)
    return files
