"""Two drawings for the page of the problem: the jump at a circle's front, and the cut behind."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Callable

from dubins_study.report.explorer.canvas import Canvas, Point
from dubins_study.report.explorer.drawings import INK, LEFT, MUTED, PAPER, RIGHT
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario

_START = Pose(0.0, 0.0, 0.0)
_STYLE = f"""
text{{font:14px system-ui,"Segoe UI",Helvetica,Arial,sans-serif;fill:{INK};
paint-order:stroke;stroke:{PAPER};stroke-width:3px;stroke-linejoin:round}}
path,polyline{{fill:none;stroke-width:3;stroke-linecap:round}}
.left{{stroke:{LEFT}}} .right{{stroke:{RIGHT}}} .rule{{stroke:{MUTED};stroke-width:1}}
.dashed{{stroke-dasharray:8 7}} .ink{{stroke:{INK}}} .head{{fill:{INK};stroke:none}}
.circle{{fill:none;stroke:{MUTED};stroke-width:1.2;stroke-dasharray:4 4}}
.target{{fill:{PAPER};stroke:{INK};stroke-width:2}}
"""


def _canvas(low: Point, size: Point, scale: float, label: str) -> Canvas:
    """Paper, and both turning circles of a vehicle at the origin that heads right."""
    canvas = Canvas(low, size, scale, label, _STYLE)
    canvas.paper(PAPER)
    for side in (1, -1):
        canvas.circle((0, side), 1, "circle")
    return canvas


def _shortest(target: Point) -> Path:
    path = shortest_path(Scenario(target_x=target[0], target_y=target[1]))
    assert path is not None, "every target can be reached"
    return path


def jump() -> str:
    """Shortest paths to a target just outside the left circle's front, and to one just inside."""
    angle, apart = 0.9, 0.05
    canvas = _canvas((-1.3, -1.4), (5.9, 3.5), 110, JUMP)
    for margin, style, name in ((-apart, "right", "inside"), (apart, "left", "outside")):
        target = (1 + margin) * math.sin(angle), 1 - (1 + margin) * math.cos(angle)
        path = _shortest(target)
        canvas.path(path, style)
        canvas.dot(target, 5, "target")
        text = f"just {name}: {path.word()}, {path.total_length:.2f} R"
        canvas.text((2.8, 0.3), text, "plain", (0, 0 if margin > 0 else 24))
    canvas.arrow((0, 0), 0, 40, "ink")
    return canvas.svg()


def cut() -> str:
    """A path LS that is driven on across the axis behind, and the path RS to the same end."""
    turn, whole = 4.0, 3.4
    until = math.tan(math.pi - turn / 2)  # the straight's length where a = 2 (pi - atan s)
    canvas = _canvas((-4.6, -2.15), (6.0, 4.3), 110, CUT)
    canvas.line((-4.6, 0), (0, 0), "rule")
    canvas.path(Path(_START, [1.0, 0.0], [turn, until]), "left")
    crossing = Path(_START, [1.0, 0.0], [turn, until]).end
    canvas.path(Path(crossing, [0.0], [whole - until]), "left dashed")
    end = Path(_START, [1.0, 0.0], [turn, whole]).end
    rival = _shortest((end.x, end.y))
    canvas.path(rival, "right")
    canvas.dot((crossing.x, crossing.y), 5, "target")
    canvas.dot((end.x, end.y), 5, "target")
    canvas.text((end.x, end.y), f"LS: {turn + whole:.2f} R", "plain", (-12, 18), "end")
    canvas.text(
        (end.x, end.y), f"{rival.word()}: {rival.total_length:.2f} R", "plain", (-12, 0), "end"
    )
    canvas.text((crossing.x, crossing.y), "here both are equal", "plain", (-10, -10), "end")
    canvas.arrow((0, 0), 0, 40, "ink")
    return canvas.svg()


JUMP = (
    "The shortest path to a target just outside the front of the left turning circle is an arc "
    "along it; to a target just inside the path turns right first and comes around"
)
CUT = (
    "A left turn and a straight that crosses the axis behind the vehicle; beyond the axis a right "
    "turn and a straight to the same point is shorter"
)
_DRAWINGS = {"jump": (jump, JUMP), "cut": (cut, CUT)}


def drawing(name: str) -> str:
    """A drawing as an image that lies within the page."""
    draw, label = _DRAWINGS[name]
    data = b64encode(draw().encode()).decode()
    image = f'<img class="drawing" alt="{label}" src="data:image/svg+xml;base64,{data}">'
    return f"```{{raw}} html\n{image}\n```"


SOURCES: dict[str, Callable[..., str]] = {"drawing": drawing}
