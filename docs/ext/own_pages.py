"""Pages of the report beside the site's.

They are the explorer, and the report of the committed benchmark.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from dubins_study import render
from dubins_study.report.page.explorer import write_explorer

# docs/problem.md shows it in a frame and links to it
_EXPLORER = "explorer-page.html"
# docs/index.md and docs/findings.md link to its index.html
_BENCHMARK = "benchmark"


def write(app: Sphinx, error: Exception | None) -> None:
    """Write the pages once the site is complete."""
    if error is None and app.builder.format == "html":
        write_explorer(Path(app.outdir) / _EXPLORER)
        rows = Path(__file__).parents[2] / "results" / "benchmark"
        render([rows], Path(app.outdir) / _BENCHMARK)


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the pages at the end of every build."""
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
