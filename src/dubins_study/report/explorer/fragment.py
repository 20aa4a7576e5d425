"""The explorer as a piece of HTML, with drawings for readers without scripts."""

from __future__ import annotations

import base64
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from dubins_study.report.explorer.drawings import MAP_ALT, PROBLEM_ALT, problem_svg, words_svg
from dubins_study.report.paper.printed import PROBLEMS, Problem
from dubins_study.study.words import BRANCHES


class Preset(NamedTuple):
    """An example that a button shows.

    Args:
        name: the button's text.
        text: x, y, heading, target x, target y and radius as the page's address has them.
        title: what there is to see.
    """

    name: str
    text: str
    title: str


def _printed(problem: Problem) -> Preset:
    number = problem.position.removeprefix("problem ")
    radius = f", R = {problem.radius}" if number == "5" else ""
    x, y = problem.target
    text = f"0,0,{int(problem.heading * 180)}deg,{x},{y},{problem.radius}"
    return Preset(f"Problem {number}{radius}", text, f"The paper's test problem {number}{radius}")


# One of each of the paper's five problems, then where the shortest path changes its kind. Just
# outside and just inside are 0.001 R from the left circle at the arc angle 0.3, where the length
# jumps by 6.235 R.
PRESETS = (
    *(_printed(PROBLEMS[f"problem {number}"]) for number in (1, 2, 3, 4)),
    _printed(PROBLEMS["problem 5, R=25"]),
    Preset("Straight behind", "0,0,0deg,-2,0,1", "The only tie of two different paths: LS and RS"),
    Preset("Inside a disc", "0,0,0deg,0,1,1", "At the left circle's centre: RL, which turns away"),
    Preset("Just outside", "0,0,0deg,0.2958,0.0437,1", "0.001 R outside the left circle: LS"),
    Preset("Just inside", "0,0,0deg,0.2952,0.0456,1", "0.001 R inside the left circle: RL"),
)
FIELDS = (
    ("target_x", "target x"),
    ("target_y", "target y"),
    ("heading", "heading, deg"),
    ("radius", "radius R"),
    ("x", "start x"),
    ("y", "start y"),
)
COPIES = (("command", "Command line"), ("python", "Python"), ("link", "Link to this scenario"))


def fragment() -> Markup:
    """The explorer's HTML; `dubins.js` and the scripts `explorer*.js` bring it to life."""
    environment = Environment(
        loader=PackageLoader("dubins_study.report.explorer", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text = environment.get_template("explorer.html.j2").render(
        presets=PRESETS,
        fields=FIELDS,
        copies=COPIES,
        branches=[branch for branch in BRANCHES if branch != "best"],
        problem=_embedded(problem_svg()),
        problem_alt=PROBLEM_ALT,
        words=_embedded(words_svg()),
        words_alt=MAP_ALT,
    )
    return Markup(text)


def _embedded(svg: str) -> str:
    """A drawing as an address, so that its style stays its own."""
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode('ascii')}"
