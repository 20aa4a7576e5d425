"""The solvers that an experiment names: `*` for all of them, `{a,b}` for several settings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.solvers.registry import SolverError, ours, registered

_BRACES = re.compile(r"\{([^{}]*)\}")
_OPENING = {"}": "{", "]": "["}  # closing bracket -> opening bracket
# Each pair of braces multiplies the number of specs, so a short line could fill the memory.
MOST_SPECS = 1000
_MAX_SPEC_CHARS = 500


def written_out(specs: Iterable[str], all_specs: Iterable[str]) -> Iterator[str]:
    """Specs with their braces expanded; `*` is replaced by `all_specs`.

    Raises:
        SolverError: if a spec's brackets do not match, or as soon as there are more than
            `MOST_SPECS`.
    """
    count = 0
    for spec in specs:
        _check_brackets(spec)
        for name in all_specs if spec == "*" else _expand_braces(spec):
            count += 1
            if count > MOST_SPECS:
                raise SolverError(
                    f"solver {spec!r:.80}: more than {MOST_SPECS} specs up to here, braces written "
                    "out; expected fewer"
                )
            yield name


def _check_brackets(spec: str) -> None:
    """Refuse a spec that is too long, or whose brackets do not match."""
    if len(spec) > _MAX_SPEC_CHARS:
        raise SolverError(
            f"solver {spec!r:.80}... has {len(spec)} characters; expected at most {_MAX_SPEC_CHARS}"
        )
    unclosed = []
    for place, character in enumerate(spec):
        if character in _OPENING.values():
            unclosed.append(character)
        elif character in _OPENING and (not unclosed or unclosed.pop() != _OPENING[character]):
            raise SolverError(
                f"solver {spec!r}: {character!r} at character {place + 1} closes nothing; expected "
                "name[setting=value] or name[setting={a,b}]"
            )
    if unclosed:
        raise SolverError(
            f"solver {spec!r}: {unclosed[-1]!r} is not closed; expected name[setting=value] or "
            "name[setting={a,b}]"
        )


def _expand_braces(spec: str) -> Iterator[str]:
    """One spec for each choice in the first pair of braces, and so on for the next pair."""
    match = _BRACES.search(spec)
    if match is None:
        yield spec
        return
    for choice in match[1].split(","):
        yield from _expand_braces(spec[: match.start()] + choice.strip() + spec[match.end() :])


def expand_solvers(specs: list[str], profile: str = "default") -> list[str]:
    """Canonical specs under a profile, without duplicates; `*` and `{a,b}` are expanded.

    Raises:
        SolverError: if a spec is not valid, or there are more than `MOST_SPECS`.
    """
    unique = dict.fromkeys(
        describe_solver(spec, profile).spec for spec in written_out(specs, registered())
    )
    return list(unique)


def untrusted_spec(specs: list[str], profile: str = "default") -> str | None:
    """The first spec that would run a plug-in file or a program on PATH; None if no spec does.

    The check runs neither the file nor the program.

    Raises:
        SolverError: if the spec of one of this package's solvers is not valid.
    """
    for spec in written_out(specs, ()):
        if ".py:" in spec or (ours(spec) and describe_solver(spec, profile).runs):
            return spec
    return None
