"""Tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from io import StringIO


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Rows as aligned text with numbers on the right; long lines are not wrapped."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for place, name in enumerate(head):
        cells = [row[place] for row in rows]
        numbers = all(cell.replace(".", "").replace("e-", "").isdigit() for cell in cells if cell)
        # `Text`, since a name from a results folder may look like markup.
        shown.add_column(Text(name), no_wrap=True, justify="right" if numbers else "left")
    for row in rows:
        shown.add_row(*(Text(cell) for cell in row))
    written = StringIO()
    Console(file=written, width=500, highlight=False).print(shown)
    return "\n".join(line.rstrip() for line in written.getvalue().strip("\n").splitlines())
