"""The page of decisions with lines of their own.

What, why and what it rules out begin such lines.
"""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

_PART = re.compile(r"\n(What|Why|Rules out|Undone): ")


def break_lines(app: Sphinx, page: str, source: list[str]) -> None:
    """Begin new lines with Markdown's two blanks.

    Two blanks at the end of a line are a line break.
    """
    if page == "decisions":
        source[0] = _PART.sub(r"  \n**\1:** ", source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Change the page's text as it is read.

    The file stays as it is.
    """
    app.connect("source-read", break_lines)
    return {"parallel_read_safe": True}
