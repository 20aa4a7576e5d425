"""The explorer of the report's page, as a page of its own beside the site's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from dubins_study.report.page.explorer import write_explorer

# docs/problem.md shows it in a frame and links to it
_FILE = "explorer-page.html"


def write(app: Sphinx, error: Exception | None) -> None:
    """Write it into the site, once all pages are there."""
    if error is None and app.builder.format == "html":
        write_explorer(Path(app.outdir) / _FILE)


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the page at the end of every build."""
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
