"""Formulas as MathML, which browsers draw themselves.

They need no script, no font and no other host.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

_LOG = logging.getLogger(__name__)

# LaTeX that the converter does not know -> LaTeX of the same look that it knows
_SPELLINGS = (("{aligned}", "{align*}"), (r"\operatorname{atan2}", r"\text{atan2}"))
# a command or a separator of columns that the converter has passed on as if it were a name
_UNREAD = re.compile(r"<m[io]>(?:\\[^<]*|&)</m[io]>")
# browsers leave no space around a function's name, and some before the second bar of |x|
_FUNCTION = re.compile(r"(<m[itext]+>(?:sin|cos|tan|arctan|atan2|max|min)</m[itext]+>)(?!<mo)")
_BAR = re.compile(r"<mo>(&#x0007C;|&#x02016;)</mo>")
_SPACE = '<mspace width="0.17em" />'
_BEFORE = re.compile(
    r"(</m(?:i|n|sub|sup|row|frac|text)>)(<m[itext]+>(?:sin|cos|tan|arctan|atan2)<)"
)
# `(eq-7)` behind a formula gives it the number 7, whatever the place of the page in the site
_NUMBER = re.compile(r".*?eq-(\d+)$")


def mathml(latex: str, display: str, place: Any = None) -> str:
    """LaTeX as MathML.

    A command that is not understood is a warning, which ends a strict build.
    """
    for spelling, known in _SPELLINGS:
        latex = latex.replace(spelling, known)
    markup: str = convert(latex, display=display)
    for unread in _UNREAD.findall(markup):
        _LOG.warning("formula %r: %s is not understood", latex, unread, location=place)
    markup = _BAR.sub(r'<mo lspace="0" rspace="0">\1</mo>', markup)
    return _BEFORE.sub(rf"\1{_SPACE}\2", _FUNCTION.sub(rf"\1{_SPACE}", markup))


def visit_inline(translator: HTML5Translator, node: nodes.math) -> None:
    """Write a formula within a line."""
    translator.body.append(mathml(node.astext(), "inline", node))
    raise nodes.SkipNode


def visit_block(translator: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula with its number, if any.

    It stands in a line of its own.
    """
    label = node.get("label") or ""
    number = _NUMBER.fullmatch(label)
    anchor = f' id="{label}"' if label else ""
    translator.body.append(f'<div class="math"{anchor}>{mathml(node.astext(), "block", node)}')
    if number:
        translator.body.append(f'<span class="eqno">(eq. {number[1]})</span>')
    translator.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer under the name that `html_math_renderer` chooses."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
