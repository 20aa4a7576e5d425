"""The explorer as a section of the report."""

from __future__ import annotations

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Place, Section, Widget
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.explorer.fragment import fragment


def explorer_section(results: Results) -> Section:
    """Every word's path to a target that the reader chooses; the same for all results."""
    caption = (
        "The map shows the shortest word of every target: LS and RS on both sides of the vehicle's "
        "axis, RL and LR (hatched) inside its turning circles, whose front halves (heavy) the "
        "length jumps across. Bold: the shortest path; thin: the other words'. Below it: every "
        "word's length against the turning radius. A click in either sets the target or the "
        "radius. Tab reaches the handles, which arrow keys move, and + and − change the radius."
    )
    lead = "Drag the target across a turning circle to see the shortest path jump to another word."
    text = (
        "What every solver is asked, for a scenario of your own: the page computes each word's "
        "path by the closed form, and its certificate from Pontryagin's conditions and the cut. An "
        "extremal satisfies the conditions; only one that stays clear of its cut is shortest."
    )
    widget = Widget("explorer", caption, fragment())
    return Section("explorer", "Explore the problem", text, (widget,), lead)


TOPIC = Topic("the explorer", explorer_section, General.EVERY, counted=True, place=Place.FRONT)
