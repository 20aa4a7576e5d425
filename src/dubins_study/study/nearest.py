"""The known name that a misspelt one most likely meant, for messages."""

from __future__ import annotations

from collections.abc import Iterable

_LEAST_ALIKE = 0.65  # difflib's ratio: twice the letters in common, over all letters of both
_MAX_CHARS = 80  # of a name; a longer one is no slip of the fingers


def nearest(name: object, known: Iterable[str]) -> str | None:
    """The known name most like a name, whatever its case; None if none is much like it."""
    if not isinstance(name, str) or not 0 < len(name) <= _MAX_CHARS:
        return None
    from difflib import get_close_matches  # only a refusal needs it

    by_folded: dict[str, str] = {}
    for candidate in known:
        by_folded.setdefault(candidate.casefold(), candidate)
    matches = get_close_matches(name.casefold(), by_folded, n=1, cutoff=_LEAST_ALIKE)
    return by_folded[matches[0]] if matches else None


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """`did you mean 'ipopt'? `, to stand before the list of all names; empty if none is near."""
    match = nearest(name, known)
    return "" if match is None else f"did you mean {match!r}? "
