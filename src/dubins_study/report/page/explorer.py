"""The section on the problem, and the explorer.

A picture shows two paths. In the explorer the reader drags the points of a question.
"""

from __future__ import annotations

import base64
from pathlib import Path as FilePath
from typing import NamedTuple

from jinja2 import Template
from markupsafe import Markup

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import General, Place, Section, Topic, Widget
from dubins_study.report.page.environment import (
    EXPLORER_SCRIPTS,
    EXPLORER_STYLES,
    TEMPLATES,
    environment,
    scripts,
    stylesheets,
)
from dubins_study.study.words import BRANCHES


class Preset(NamedTuple):
    """An example that a button shows."""

    name: str  # the button's text
    text: str  # the scenario as the page's address has it
    title: str  # what there is to see


# The paper's five problems, then places where the shortest path changes its kind. Just
# outside and just inside are 0.001 R from the left circle at the arc angle 0.3, where the length
# jumps by 6.235 R.
PRESETS = (
    Preset("Problem 1", "0,0,120deg,10,5,1", "The paper's test problem 1"),
    Preset("Problem 2", "0,0,120deg,-6,3,1", "The paper's test problem 2"),
    Preset("Problem 3", "0,0,60deg,-1,5,1", "The paper's test problem 3"),
    Preset("Problem 4", "0,0,60deg,-2,-5,1", "The paper's test problem 4"),
    Preset("Problem 5, R = 25", "0,0,120deg,-80,20,25", "The paper's test problem 5, R = 25"),
    Preset("Straight behind", "0,0,0deg,-2,0,1", "The only tie of two different paths: LS and RS"),
    Preset("Inside a disc", "0,0,0deg,0,1,1", "At the left circle's centre: RL, which turns away"),
    Preset("Just outside", "0,0,0deg,0.2958,0.0437,1", "0.001 R outside the left circle: LS"),
    Preset("Just inside", "0,0,0deg,0.2952,0.0456,1", "0.001 R inside the left circle: RL"),
    Preset("Pose", "0,0,30deg,4,1,1;final=180deg", "A final heading is given: six words"),
    Preset("Route", "0,0,30deg,10,5,1;via=4,1,6,-2;final=90deg", "Two points to pass on the way"),
    Preset("Tour", "0,0,30deg,12,3,1;via=9,-2,3,5,-3,4,4,-3,8,6;order=free", "Points in any order"),
)


def _drawing(name: str) -> str:
    """A drawing of the templates as a data URL.

    As an image, its styles cannot affect the page.
    """
    content = (TEMPLATES / f"{name}.svg").read_bytes()
    return f"data:image/svg+xml;base64,{base64.b64encode(content).decode('ascii')}"


def _template(name: str) -> Template:
    templates = environment()
    templates.filters |= {"drawing": _drawing}
    return templates.get_template(name)


def _explorer() -> Markup:
    """The explorer's HTML, without its scripts.

    The scripts `dubins*.js` and `explorer*.js` draw in it.
    """
    branches = [branch for branch in BRANCHES if branch != "best"]
    return Markup(_template("explorer.html.j2").render(presets=PRESETS, branches=branches))


def explorer_section(results: Results) -> Section:
    """The section on the problem, with the explorer.

    A picture shows two paths that arrive. The section is the same for all results.
    """
    lead = "Which path from the start to the target is the shortest?"
    two_paths = (
        "The vehicle drives forward only and cannot turn tighter than a circle of radius R. Its "
        "shortest path is made of arcs of this radius and straight lines. The word of a path names "
        "them in order: L is a left turn, R a right turn, S straight. Here RS is the "
        "shortest. LS arrives too, but is more than twice as long: a solver that finds LS may "
        "report it as the shortest."
    )
    try_it = (
        "Drag the target T: the bold path is the shortest, and each colour of the map is one word. "
        "Drag T into a turning circle, across the thick black arc: the path jumps to another word "
        "and gets longer. Route and Tour have via points, which the path must pass on the way."
    )
    problem = Widget("problem", two_paths, Markup(_template("problem.html.j2").render()))
    explorer = Widget("explorer", try_it, _explorer())
    return Section("explorer", "The problem", "", (problem, explorer), lead)


TOPIC = Topic("the problem", explorer_section, General.EVERY, place=Place.FRONT)


def write_explorer(file: FilePath) -> FilePath:
    """Write the explorer as a page of its own.

    The page opens offline. The path of the file comes back.
    """
    page = environment().get_template("explorer-page.html.j2")
    text = page.render(
        title="Explore the shortest path of a vehicle that cannot turn tightly",
        style=stylesheets(EXPLORER_STYLES),
        explorer=_explorer(),
        scripts=scripts(EXPLORER_SCRIPTS),
    )
    file.write_text(text, encoding="utf-8", newline="\n")
    return file
