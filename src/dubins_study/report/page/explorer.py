"""The explorer: paths to a target, and routes, that the reader drags; a section and a page."""

from __future__ import annotations

import base64
from pathlib import Path as FilePath
from typing import NamedTuple

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


# One of each of the paper's five problems, then where the shortest path changes its kind. Just
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


def _explorer() -> Markup:
    """The explorer's HTML; `dubins.js` and the scripts `explorer*.js` bring it to life."""
    template = environment().get_template("explorer.html.j2")
    # drawings as addresses, so that their styles stay their own
    drawings = {
        name: base64.b64encode((TEMPLATES / f"{name}.svg").read_bytes()).decode("ascii")
        for name in ("problem", "words")
    }
    branches = [branch for branch in BRANCHES if branch != "best"]
    return Markup(template.render(presets=PRESETS, branches=branches, drawings=drawings))


def explorer_section(results: Results) -> Section:
    """Every word's path to a target that the reader chooses; the same for all results."""
    caption = (
        "Map: the shortest word of every target; the length jumps across the heavy half circles. "
        "Bold: the shortest path; thin: other words'. Tab reaches the handles; arrow keys move "
        "them, + and − change the radius. Certificates: of Pontryagin's conditions and the cut; "
        "clear of its cut, an extremal is shortest."
    )
    lead = (
        "Drag the target across a turning circle to see the shortest path jump to another word. "
        "Add via points or a final heading to plan a route, in the given order or in any."
    )
    widget = Widget("explorer", caption, _explorer())
    return Section("explorer", "Explore the problem", "", (widget,), lead)


TOPIC = Topic("the explorer", explorer_section, General.EVERY, place=Place.FRONT)


def write_explorer(file: FilePath) -> FilePath:
    """Write the explorer as a page of its own, which opens offline; returns the file."""
    page = environment().get_template("explorer-page.html.j2")
    text = page.render(
        title="Explore the shortest bounded-curvature path to a point",
        style=stylesheets(EXPLORER_STYLES),
        explorer=_explorer(),
        scripts=scripts(EXPLORER_SCRIPTS),
    )
    file.write_text(text, encoding="utf-8", newline="\n")
    return file
