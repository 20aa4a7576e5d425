"""The words of the page, and links from their first use to what they mean."""

from __future__ import annotations

import re
from typing import NamedTuple

from markupsafe import Markup


class Word(NamedTuple):
    """A word of the glossary."""

    term: str
    meaning: str  # one or two sentences
    forms: str  # a pattern of the forms in which a text uses it

    @property
    def anchor(self) -> str:
        """The end of its anchor on the page."""
        return re.sub(r"[^a-z]+", "-", self.term.lower())


GLOSSARY = (
    Word(
        "closed form",
        "The formula for the shortest path: the reference that every answer is compared with.",
        "closed form",
    ),
    Word(
        "formulation",
        "The mathematical problem that is handed over, such as one NLP a word or optimal control.",
        "formulations?",
    ),
    Word("engine", "The library that solves it, such as Ipopt, SLSQP or SCIP.", "engines?"),
    Word(
        "initial guess",
        "Where an engine begins its search: at zero, along the bearing of the target, at random, "
        "or at another solver's path (warm).",
        "initial guess(?:es)?",
    ),
    Word(
        "method",
        "A formulation with an engine, an initial guess and settings. On the command line it is a "
        "solver, written as a spec such as ipopt[presolve=true].",
        "methods?",
    ),
    Word(
        "word",
        "The kinds of a path's parts in order: L and R are turns to the left and right with the "
        "smallest radius, S is straight. One of LS, RS, LR and RL is shortest.",
        "words?(?= |,|\\.|;|:|$)",
    ),
    Word(
        "question",
        "A scenario (start pose, target, turning radius), a branch (the best path, or that of one "
        "word) and an initial guess. In a share all attempts of a solver at one scenario and "
        "branch count as one trial: repeats, and cold and warm starts.",
        "questions?",
    ),
    Word(
        "right",
        "The path arrives, and its gap is at most the tolerance (1e-4 unless the run says "
        "otherwise): found by driving the path again from its controls.",
        "(?:(?<=answered )|(?<=is )|(?<=are ))right|right (?:answers|on)|right(?=:)",
    ),
    Word(
        "gap",
        "How much longer a path is than the shortest, over the larger of its length and R.",
        "gaps?",
    ),
    Word(
        "false claim",
        "A solver says more than the check finds: optimal for a longer path, a path that misses, "
        "or infeasible where a path exists. False bounds, lower bounds above the shortest length, "
        "are counted apart from them, or with them where the text says so.",
        "false claims?",
    ),
    Word(
        "wrong basin",
        "A local minimum that is not the shortest path: it turns by another angle, or is of "
        "another word.",
        "wrong basins?",
    ),
    Word(
        "presolve",
        "Words that cannot exist or cannot be shortest are left out by geometry before any engine "
        "is called.",
        "presolved?",
    ),
    Word(
        "certificate",
        "The proof that the check itself finds, from a path's controls alone, that no path is "
        "shorter.",
        "certificates?",
    ),
    Word(
        "margin",
        "The distance from the target to the nearer of the two turning circles at the start, in "
        "turning radii. Next to a circle the shortest length jumps.",
        "margins?",
    ),
    Word(
        "95 % interval",
        "The numbers that fit the rows: Wilson's for shares, a bootstrap over scenarios for "
        "ratios.",
        "95 % intervals?",
    ),
)


class Glossed:
    """Links the first use of every word on one page to the glossary."""

    def __init__(self) -> None:
        self._left = {word: re.compile(rf"\b(?:{word.forms})", re.IGNORECASE) for word in GLOSSARY}

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
            parts += [link.format(word.anchor, word.meaning, text[start:stop])]
            end = stop
            del self._left[word]
        return Markup("").join([*parts, Markup.escape(text[end:])])
