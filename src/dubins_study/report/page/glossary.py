"""The words of the page, and links from their first use to what they mean."""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files
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
# by what they are about, in this order
GLOSSARY = {
    part: [Word(term, **texts) for term, texts in words.items()]
    for part, words in tomllib.loads(_TEXT).items()
}
WORDS = [word for words in GLOSSARY.values() for word in words]


class Glossed:
    """Links the first use of every word on one page to the glossary."""

    def __init__(self) -> None:
        linked = (word for word in WORDS if word.forms)
        self._left = {word: re.compile(rf"\b(?:{word.forms})", re.IGNORECASE) for word in linked}

    def __call__(self, text: str) -> Markup:
        """A text as HTML, with a link at each word that no earlier text used."""
        found: list[tuple[int, int, Word]] = []
        for word, pattern in self._left.items():
            match = pattern.search(text)
            if match and not any(match.start() < e and s < match.end() for s, e, _ in found):
                found.append((*match.span(), word))
        parts, end = [], 0
        for start, stop, word in sorted(found):
            link = Markup('<a class="term" href="#term-{}" title="{}">{}</a>')
            parts += [Markup.escape(text[end:start])]
            parts += [link.format(word.anchor, word.plain, text[start:stop])]
            end = stop
            del self._left[word]
        return Markup("").join([*parts, Markup.escape(text[end:])])
