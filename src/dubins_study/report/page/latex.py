"""`report.tex`: the whole report for pdfTeX, with its tables and figures from their files."""

from __future__ import annotations

from collections.abc import Sequence

from jinja2 import Environment

from dubins_study.report.data.results import Folder
from dubins_study.report.elements.content import Picture, Section
from dubins_study.report.page.tex_layout import PAGE_HEIGHT, PAGE_WIDTH, layout_of
from dubins_study.report.page.tex_text import tex
from dubins_study.report.paper.printed import PAPER

_MM = 25.4  # in an inch
_CAPTION = 30.0  # mm that a figure's caption may take


def document(environment: Environment, sections: Sequence[Section], runs: Sequence[Folder]) -> str:
    """The text of `report.tex`, which pdflatex compiles in the report's folder.

    Args:
        environment: that of the other formats, for its filters and tests.
        sections: of the report.
        runs: the results folders.
    """
    # Braces mean something to TeX, so the template's commands stand in `<< >>` and `<% %>`.
    latex = environment.overlay(
        block_start_string="<%",
        block_end_string="%>",
        variable_start_string="<<",
        variable_end_string=">>",
        comment_start_string="<#",
        comment_end_string="#>",
        autoescape=False,
    )
    latex.filters |= {"tex": tex, "layout": layout_of, "shrunk": _shrunk}
    page = {"width": PAGE_WIDTH, "height": PAGE_HEIGHT}
    template = latex.get_template("report.tex.j2")
    printed = [section for section in sections if section.printed]
    return template.render(sections=printed, runs=runs, paper=PAPER.citation, **page)


def _shrunk(picture: Picture) -> str:
    """Options that make a figure fit if it is larger than the page; else it keeps its size."""
    width, height = (float(size) * _MM for size in picture.figure.get_size_inches())
    room = PAGE_HEIGHT - _CAPTION
    if height <= room and width <= PAGE_WIDTH + 0.01:  # mm; widths are rounded to points
        return ""
    return f"[width={PAGE_WIDTH:g}mm,height={room:g}mm,keepaspectratio]"
