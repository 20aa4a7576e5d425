"""The explorer as a section of the report."""

from __future__ import annotations

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import General, Place, Section, Topic, Widget
from dubins_study.report.explorer.fragment import fragment


def explorer_section(results: Results) -> Section:
    """Every word's path to a target that the reader chooses; the same for all results."""
    caption = (
        "Map: the shortest word of every target; the length jumps across the heavy half circles. "
        "Bold: the shortest path; thin: other words'. Tab reaches the handles; arrow keys move "
        "them, + and − change the radius. Certificates: of Pontryagin's conditions and the cut; "
        "clear of its cut, an extremal is shortest."
    )
    lead = "Drag the target across a turning circle to see the shortest path jump to another word."
    widget = Widget("explorer", caption, fragment())
    return Section("explorer", "Explore the problem", "", (widget,), lead)


TOPIC = Topic("the explorer", explorer_section, General.EVERY, place=Place.FRONT)
