"""Solvers as an experiment names them: `*`, and several settings in braces."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from dubins_study.experiments.plan.solver_description import described
from dubins_study.solvers.registry import SolverError, ours, registered

_BRACES = re.compile(r"\{([^{}]*)\}")
_CLOSES = {"}": "{", "]": "["}
# a few braces say more than any memory holds
MOST_SPECS = 1000
_LONGEST = 500  # characters of a spec


def expand_solvers(specs: list[str], profile: str = "default") -> list[str]:
    """Canonical specs under a profile, `*` and `{a,b}` written out, each once."""
    expanded: dict[str, None] = {}
    for name in _written_out(specs, registered()):
        expanded.setdefault(described(name, profile).spec)
    return list(expanded)


def foreign(specs: list[str], profile: str = "default") -> str | None:
    """The first spec that runs code beside this package's: a plug-in file, a program on PATH.

    No such code is run to find out.

    Raises:
        SolverError: if a spec of this package's own is not valid.
    """
    for name in _written_out(specs, ()):
        if ".py:" in name or (ours(name) and described(name, profile).runs):
            return name
    return None


def _written_out(specs: Iterable[str], every: Iterable[str]) -> Iterator[str]:
    """Specs without braces; `every` takes the place of `*`.

    Raises:
        SolverError: if there are more than `MOST_SPECS`, once so many were handed out.
    """
    number = 0
    for spec in specs:
        _check_brackets(spec)
        for name in every if spec == "*" else _expand_braces(spec):
            number += 1
            if number > MOST_SPECS:
                raise SolverError(
                    f"solver {spec!r:.80}: more than {MOST_SPECS} specs up to here, braces written "
                    "out; expected fewer"
                )
            yield name


def _check_brackets(spec: str) -> None:
    if len(spec) > _LONGEST:
        raise SolverError(
            f"solver {spec!r:.80}... has {len(spec)} characters; expected at most {_LONGEST}"
        )
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
