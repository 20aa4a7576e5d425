"""The directive `generated`: Markdown that is computed.

It is computed at build time, never typed by hand.

    ```{generated} settings nlp
    What readers of the file itself see in its place.
    ```

Its first word names a function of `SOURCES`; the rest of the line is that function's argument.
"""

from __future__ import annotations

import benchmark_numbers
import command_line
import package_tables
import paper_tables
import toml_reference
from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

SOURCES = (
    package_tables.SOURCES
    | toml_reference.SOURCES
    | command_line.SOURCES
    | benchmark_numbers.SOURCES
    | paper_tables.SOURCES
)


class Generated(SphinxDirective):
    """Markdown of one function of `SOURCES`."""

    required_arguments = 1
    has_content = True
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        name, _, argument = self.arguments[0].partition(" ")
        if name not in SOURCES:
            known = ", ".join(sorted(SOURCES))
            raise self.error(f"nothing generates {name!r}; choose one of: {known}")
        try:
            text = SOURCES[name](argument) if argument else SOURCES[name]()
        except LookupError as error:
            raise self.error(f"{name} {argument!r}: {error}") from error
        parent = nodes.container()
        lines = StringList(text.splitlines(), source=f"generated {name}")
        self.state.nested_parse(lines, self.content_offset, parent)
        return parent.children


def setup(app: Sphinx) -> dict[str, object]:
    """Register the directive."""
    app.add_directive("generated", Generated)
    return {"parallel_read_safe": True}
