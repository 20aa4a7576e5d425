"""The glossary of the page, and links to it.

On each page, only the first use of a word is a link.
"""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files
from itertools import chain
from typing import NamedTuple

from markupsafe import Markup


class Word(NamedTuple):
    """A word of the glossary.

    `forms` is a regular expression for the word in a text; a word without one is never linked.
    """

    term: str
    meaning: str
    forms: str = ""
    more: str = ""

    @property
    def anchor(self) -> str:
        """The word's anchor on the page, without `term-`."""
        return re.sub(r"[^a-z]+", "-", self.term.lower())

    @property
    def plain(self) -> str:
        """The meaning without the marks of code."""
        return self.meaning.replace("`", "")


_TEXT = (files(__package__) / "glossary.toml").read_text(encoding="utf-8")
# by subject, in this order
GLOSSARY = {
    part: [Word(term, **texts) for term, texts in words.items()]
    for part, words in tomllib.loads(_TEXT).items()
}
WORDS = list(chain.from_iterable(GLOSSARY.values()))


# One group for each linked word, so that a match's `lastindex` is the word's number, from 1.
_LINKED = [word for word in WORDS if word.forms]
_FORMS = "|".join(f"({word.forms})" for word in _LINKED)
_FIRST_OF = re.compile(rf"\b(?:{_FORMS})", re.IGNORECASE)


class Glossed:
    """Link words of a page's texts to the glossary.

    An object serves one page: it remembers which words it has linked.
    """

    def __init__(self) -> None:
        self._used: set[Word] = set()

    def __call__(self, text: str) -> Markup:
        """A text as HTML, with links to the glossary.

        A word is a link unless an earlier text of the page has one for it.
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
