r"""A table as TeX, for `report.tex` and for an `\input` in a paper."""

from __future__ import annotations

from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.content import Table
from dubins_study.report.page.tex_layout import (
    GAP,
    RIGHT,
    ROW_GAP,
    heading_lines,
    layout_of,
    printed_texts,
)
from dubins_study.report.page.tex_text import tex

# Package -> what shows that a table needs it.
_PACKAGES = {
    "amssymb": r"\checkmark",
    "booktabs": r"\toprule",
    "longtable": "{longtable}",
    "pifont": r"\ding",
}


def to_tex(table: Table) -> str:
    """A `tabular` with booktabs rules; a `longtable` if it is longer than a page."""
    layout, texts = layout_of(table), printed_texts(table)
    columns = list(zip(table.columns, layout.widths, strict=True))
    heading = [
        _cell(heading_lines(column, texts, place), column, width, "b")
        for place, (column, width) in enumerate(columns)
    ]
    head = [r"\toprule", _row(heading), r"\midrule"]
    several = any("\n" in text for row in texts for text in row) or any(layout.widths)
    rows = [
        _row(
            [
                _cell(text.split("\n"), column, width, "t")
                for text, (column, width) in zip(row, columns, strict=True)
            ],
            rf"\addlinespace[{ROW_GAP:g}mm]" if several else "",
        )
        for row in texts
    ]
    if layout.long:
        kind, inside = "longtable", [*head, r"\endhead", r"\bottomrule", r"\endfoot", *rows]
    else:
        kind, inside = "tabular", [*head, *rows, r"\bottomrule"]
    place = "[l]" if layout.long else ""
    spec = "".join(_column(column, width) for column, width in columns)
    body = "\n".join(
        [
            rf"\begingroup\{layout.size}\setlength{{\tabcolsep}}{{{GAP / 2:g}mm}}%",
            rf"\begin{{{kind}}}{place}{{@{{}}{spec}@{{}}}}",
            *inside,
            rf"\end{{{kind}}}%",
            r"\endgroup",
        ]
    )
    packages = ", ".join(name for name, sign in _PACKAGES.items() if sign in body)
    return f"% Needs the packages {packages}.\n{body}\n"


def _column(column: Column, width: float | None) -> str:
    if width is not None:
        return f"p{{{width:.1f}mm}}"
    return "r" if column.kind in RIGHT else "l"


def _row(cells: list[str], gap: str = "") -> str:
    """A line of the table; `gap` is a command for the distance to the next one."""
    row = " & ".join(cells) + r" \tabularnewline" + gap
    return "{}" + row if row.startswith("[") else row  # or TeX would read it as a distance


def _cell(lines: list[str], column: Column, width: float | None, place: str) -> str:
    """One cell; `place`, b or t, is the line of several that stands beside the other cells."""
    escaped = [tex(line) for line in lines]
    if column.kind in ("code", "command") and place == "t":
        escaped = [rf"\texttt{{{line}}}" for line in escaped]
    if width is not None:
        return rf"\raggedright {' '.join(escaped)}"
    if len(escaped) == 1:
        return escaped[0]
    stack = r" \\ ".join(escaped)
    return rf"\begin{{tabular}}[{place}]{{@{{}}{_column(column, None)}@{{}}}}{stack}\end{{tabular}}"
