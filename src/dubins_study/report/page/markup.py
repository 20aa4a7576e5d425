"""Tables as CSV and LaTeX; figures as HTML elements.

Text from outside is escaped.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import pandas as pd
from markupsafe import Markup

from dubins_study.report.elements import style
from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.content import Section, Table

_RIGHT = {"number": "r", "cell": "r"}  # kinds of columns that are aligned right

_FORMULA = tuple("=+-@\t")  # a spreadsheet reads text that starts with one of these as a formula


def to_csv(table: Table) -> str:
    """The table as a CSV text, with full digits.

    It has the shown columns and those of `Table.numbers`; missing values are empty. A text that a
    spreadsheet would read as a formula gets a leading apostrophe.
    """
    keys = dict.fromkeys([*(column.key for column in table.columns), *table.numbers])
    frame = table.frame[list(keys)].copy()
    for column in table.columns:
        if column.kind != "number":
            frame[column.key] = frame[column.key].map(_no_formula)
    return str(frame.to_csv(index=False, lineterminator="\n"))


def _no_formula(value: object) -> object:
    if isinstance(value, str) and value.startswith(_FORMULA):
        return f"'{value}"
    return value


def to_tex(table: Table) -> str:
    """The table as the text of a LaTeX `longtable`.

    It needs booktabs and, since it is UTF-8, LuaLaTeX. Solvers have their short names.
    """
    frame = pd.DataFrame(table.texts(), columns=[column.title for column in table.columns])
    for place, column in enumerate(table.columns):
        if column.kind == "solver":
            specs = frame.iloc[:, place]
            frame.isetitem(place, [table.labels.get(spec, spec) for spec in specs])
    styled = frame.style.format(_tex_cell, escape="latex").hide(axis="index")
    styled = styled.format_index(escape="latex", axis="columns")
    sides = [_RIGHT.get(column.kind, "l") for column in table.columns]
    return styled.to_latex(column_format="".join(sides), environment="longtable", hrules=True)


def _tex_cell(text: object) -> str:
    """A cell's text on one line.

    TeX would read a bracket at the start of a row as a distance.
    """
    return str(text).replace("\n", " ").replace("[", "{[}")


_SHOWN = (
    Column("file", "table", kind="code"),
    Column("column", "column", kind="code"),
    Column("heading", "heading on the page", kind="text"),
    Column("section", "section", kind="text"),
)


def dictionary(sections: Iterable[Section]) -> Table:
    """A table that explains the columns of CSV files.

    It has one line for each column, in the order of the page.
    """
    lines: list[tuple[str, ...]] = []
    for section in sections:
        for block in section.blocks:
            if isinstance(block, Table):
                headings = _headings(block).items()
                lines += [(block.name, *heading, section.title) for heading in headings]
    frame = pd.DataFrame(lines, columns=["file", "column", "heading", "section"])
    return Table("dictionary", "The columns of the tables.", frame, _SHOWN)


def _headings(table: Table) -> dict[str, str]:
    """Map a CSV file's columns to their headings.

    The heading is empty for a column that the page does not show.
    """
    headings = {column.key: " ".join(column.title.split()) for column in table.columns}
    return headings | {key: "" for key in table.numbers if key not in headings}


# CSS variables for the figures' colours, so that figures follow the page's light or dark mode.
_VARIABLES = {
    style.INK: "--ink",
    style.MUTED: "--muted",
    style.RULE: "--rule",
    style.PAPER: "--paper",
    **style.VARIABLES,
}
_COLOUR = re.compile("|".join(map(re.escape, _VARIABLES)))
_METADATA = re.compile(r"<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)
_TAG = re.compile(r"<[^>]+>")
_STYLE = re.compile(r' style="[^"]*"')
_FILL = re.compile(r' fill="(#\w{6})"')  # of hatches; only a style can hold a variable
_ID = re.compile(r' id="|href="#|url\(#')  # the text before an id


def inline(svg: str, name: str, alt: str) -> Markup:
    """An SVG file's text as an HTML element.

    `name` is put before its ids, so that ids of several figures differ. Colours become variables of
    the page. `alt` is the text for readers who do not see it.
    """

    def of_page(tag: re.Match[str]) -> str:
        text = _ID.sub(lambda before: f"{before.group()}{name}-", tag.group())
        return _STYLE.sub(_following, _FILL.sub(r' style="fill: \1"', text))

    body = _TAG.sub(of_page, _METADATA.sub("", svg[svg.index("<svg") :]))
    label = Markup("<svg role='img' aria-label='{}'").format(alt)
    return label + Markup(body.removeprefix("<svg"))


def _following(match: re.Match[str]) -> str:
    """A `style` attribute that follows the page.

    Its colours become CSS variables, and its font that of the page.
    """
    text = _COLOUR.sub(lambda colour: f"var({_VARIABLES[colour.group()]})", match.group())
    return text.replace("'DejaVu Sans'", "inherit")
