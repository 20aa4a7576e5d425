"""The paper that the study is about, as the page, `report.md`, `report.tex` and others cite it.

`CITATION.cff` says the same; a test compares them. The copy of the paper that the printed tables
were read from names neither authors nor year, so none are given here.
"""

from __future__ import annotations

from typing import NamedTuple


class Paper(NamedTuple):
    """What is known of a paper.

    Args:
        title: as printed.
        authors: empty if they are not known.
        year: None if it is not known.
    """

    title: str
    authors: tuple[str, ...] = ()
    year: int | None = None

    @property
    def citation(self) -> str:
        """The paper in one line, for instance `A. Author, B. Author (1957): “Title”`."""
        year = "" if self.year is None else f" ({self.year})"
        before = f"{', '.join(self.authors)}{year}: " if self.authors else ""
        missing = [
            name for name, known in (("authors", self.authors), ("year", self.year)) if not known
        ]
        after = f" ({' and '.join(missing)} unknown to this study)" if missing else ""
        return f"{before}“{self.title}”{after}"


PAPER = Paper("Mathematical Model for Optimal Dubins Path to Intercept a Stationary Target")
