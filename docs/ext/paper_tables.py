"""The paper: its citation and its printed numbers.

The numbers are shown with what became of them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import yaml
from markdown_text import prose, table

from dubins_study.report.paper.audit import audit
from dubins_study.report.paper.printed import misprints

_CITATION = Path(__file__).parents[2] / "CITATION.cff"
_TITLE = "Mathematical Model for Optimal Dubins Path to Intercept a Stationary Target"


def citation() -> str:
    """The paper as `CITATION.cff` names it among its references."""
    known = yaml.safe_load(_CITATION.read_text(encoding="utf-8"))
    (paper,) = [one for one in known["references"] if one["title"] == _TITLE]
    people = [one for one in paper["authors"] if "family-names" in one]
    names = ", ".join(f"{one.get('given-names', '')} {one['family-names']}" for one in people)
    where = [str(paper[key]) for key in ("journal", "year", "doi", "url") if key in paper]
    parts = [names, f"*{prose(paper['title'])}*", *map(prose, where)]
    return f"{'. '.join(filter(None, parts))}. {prose(paper.get('notes', ''))}"


def audit_table() -> str:
    """Printed numbers that are no correct roundings.

    They are recomputed now.
    """
    rows = [
        (
            cell["table"],
            f"{cell['label']}, {cell['path']}",
            cell["quantity"],
            cell["printed"],
            cell["exact"][:11],
            cell["verdict"],
        )
        for cell in misprints(audit())
    ]
    return table(("table", "path", "number", "printed", "exact", "finding"), rows)


SOURCES: dict[str, Callable[..., str]] = {"citation": citation, "audit": audit_table}
