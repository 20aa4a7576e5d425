"""Solvers as an experiment names them: `*`, and several settings in braces."""

from __future__ import annotations

import re
from collections.abc import Iterator

from solvers.registry import SolverError, canonical, registered

_BRACES = re.compile(r"\{([^{}]*)\}")
_CLOSES = {"}": "{", "]": "["}


def expand_solvers(specs: list[str], profile: str = "default") -> list[str]:
    """Canonical specs under a profile, `*` and `{a,b}` written out, each once."""
    expanded: dict[str, None] = {}
    for spec in specs:
        _check_brackets(spec)
        for name in registered() if spec == "*" else _expand_braces(spec):
            expanded.setdefault(canonical(name, profile))
    return list(expanded)


def _check_brackets(spec: str) -> None:
    opened = []
    for place, letter in enumerate(spec):
        if letter in _CLOSES.values():
            opened.append(letter)
        elif letter in _CLOSES and (not opened or opened.pop() != _CLOSES[letter]):
            raise SolverError(
                f"solver {spec!r}: {letter!r} at character {place + 1} closes nothing; expected "
                "name[setting=value] or name[setting={a,b}]"
            )
    if opened:
        raise SolverError(
            f"solver {spec!r}: {opened[-1]!r} is not closed; expected name[setting=value] or "
            "name[setting={a,b}]"
        )


def _expand_braces(spec: str) -> Iterator[str]:
    match = _BRACES.search(spec)
    if match is None:
        yield spec
        return
    for choice in match[1].split(","):
        yield from _expand_braces(spec[: match.start()] + choice.strip() + spec[match.end() :])
