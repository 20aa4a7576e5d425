"""The report's sections in the order of the page; each is left out if it has no rows."""

from __future__ import annotations

from collections.abc import Callable

from report.content import Section
from report.load import Results
from report.section_paper import figures_section, paper_section
from report.section_summary import success_section, summary_section

SECTIONS: dict[str, Callable[[Results], Section | None]] = {
    "summary": summary_section,
    "the paper's tables": paper_section,
    "the paper's figures": figures_section,
    "success and gaps": success_section,
}
