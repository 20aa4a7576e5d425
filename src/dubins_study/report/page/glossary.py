"""The glossary of the page, and links to it.

A word's first use on a page is the link.
"""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files
from itertools import chain
from typing import NamedTuple

from markupsafe import Markup


class Word(NamedTuple):
    """A word of the glossary."""

    term: str
    meaning: str
    forms: str = ""
    more: str = ""

    @property
    def anchor(self) -> str:
        """The end of its anchor on the page."""
        return re.sub(r"[^a-z]+", "-", self.term.lower())

    @property
    def plain(self) -> str:
        """The meaning as a text of the page."""
        return self.meaning.replace("`", "")


_TEXT = (files(__package__) / "glossary.toml").read_text(encoding="utf-8")
# by subject, in this order
GLOSSARY = {
    part: [Word(term, **texts) for term, texts in words.items()]
    for part, words in tomllib.loads(_TEXT).items()
}
WORDS = list(chain.from_iterable(GLOSSARY.values()))


_LINKED = [word for word in WORDS if word.forms]
_FORMS = "|".join(f"({word.forms})" for word in _LINKED)
_FIRST_OF = re.compile(rf"\b(?:{_FORMS})", re.IGNORECASE)


class Glossed:
    """Links each word's first use to the glossary.

    The first use on one page.
    """

    def __init__(self) -> None:
        self._used: set[Word] = set()

    def __call__(self, text: str) -> Markup:
        """A text as HTML with links to the glossary.

        A link is at each word that no earlier text used.
        """
        html = Markup("")
        end = 0
        for match in _FIRST_OF.finditer(text):
            word = _LINKED[(match.lastindex or 1) - 1]
            if word in self._used:
                continue
            self._used.add(word)
            link = Markup('<a class="term" href="#term-{}" title="{}">{}</a>')
            html += Markup.escape(text[end : match.start()])
            html += link.format(word.anchor, word.plain, match.group())
            end = match.end()
        return html + Markup.escape(text[end:])
