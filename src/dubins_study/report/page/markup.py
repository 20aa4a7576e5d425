"""A table as CSV, Markdown and TeX; all text from outside is escaped here."""

from __future__ import annotations

import re

from dubins_study.report.elements.content import Table

_TEX = {symbol: f"\\{symbol}" for symbol in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    **{"~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "|": r"\textbar{}"},
    **{"<": r"\textless{}", ">": r"\textgreater{}", "≤": r"$\leq$", "≥": r"$\geq$"},
    **{"−": r"$-$", "–": "--", "∞": r"$\infty$", "×": r"$\times$", "·": r"$\cdot$"},
    **{"µ": r"$\mu$", "π": r"$\pi$", "ζ": r"$\zeta$", "√": r"$\surd$", "½": r"$\frac12$"},
    **{"✓": r"\checkmark{}", "✗": r"$\times$", "⁻": r"$^{-}$", "²": r"$^2$"},
    **{"₁": r"$_1$", "₂": r"$_2$", "₃": r"$_3$", "\u202f": r"\,", "\u00a0": "~"},
}
# Markdown's special characters: anywhere, at the start of a line, and after a list's number.
_MARKDOWN = re.compile(r"([\\`*_\[\]|~$]|^[#+=-]|(?<=^\d)[.)](?=\s))")

_RIGHT = ("number", "cell")  # kinds of columns that are aligned right

_SPECS = ("code", "solver")  # kinds of columns whose texts a command reads

_FORMULA = tuple("=+-@\t")  # a spreadsheet reads text that starts with one of these as a formula


def tex(text: str) -> str:
    """Escape text so that TeX prints it unchanged."""
    return "".join(_TEX.get(character, character) for character in _one_line(text))


def markdown(text: str) -> str:
    """Escape text so that Markdown, and HTML made from it, show it unchanged."""
    plain = _one_line(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _MARKDOWN.sub(r"\\\1", plain)


def _one_line(text: str) -> str:
    return " ".join(text.split("\n")).replace("\r", " ")


def to_csv(table: Table) -> str:
    """The shown columns and those of `Table.numbers`: full digits, missing values empty.

    A text that a spreadsheet would read as a formula gets a leading apostrophe.
    """
    keys = dict.fromkeys([*(column.key for column in table.columns), *table.numbers])
    shown = table.frame[list(keys)].copy()
    for column in table.columns:
        if column.kind != "number":
            shown[column.key] = shown[column.key].map(_no_formula)
    return str(shown.to_csv(index=False, lineterminator="\n"))


def _no_formula(value: object) -> object:
    return f"'{value}" if isinstance(value, str) and value[:1] in _FORMULA else value


def to_markdown(table: Table) -> str:
    """A pipe table; numbers are aligned right."""
    rule = ["---:" if column.kind in _RIGHT else "---" for column in table.columns]
    rows = [[markdown(column.title) for column in table.columns], rule]
    rows += [[markdown(text) for text in row] for row in table.texts()]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def to_tex(table: Table) -> str:
    """A `tabular` with booktabs rules, ready for `\\input`."""
    spec = "".join("r" if column.kind in _RIGHT else "l" for column in table.columns)
    lines = [rf"\begin{{tabular}}{{{spec}}}", r"\toprule"]
    lines += [_tex_row([tex(column.title) for column in table.columns]), r"\midrule"]
    for row in table.texts():
        pairs = zip(row, table.columns, strict=True)
        cells = [rf"\texttt{{{tex(t)}}}" if c.kind in _SPECS else tex(t) for t, c in pairs]
        lines.append(_tex_row(cells))
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}"]) + "\n"


def _tex_row(cells: list[str]) -> str:
    return " & ".join(cells) + r" \\"
