"""What is wrong with the solvers that an experiment's file lists, whether it is valid or not."""

from __future__ import annotations

from typing import Any

from dubins_study.experiments.definition.key_conflicts import tables
from dubins_study.experiments.definition.messages import Problem
from dubins_study.experiments.definition.spec_braces import MOST_SPECS, written_out
from dubins_study.experiments.definition.toml_lines import KeyPath
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.experiments.plan.solver_specs import untrusted_spec
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.registry import SolverError

_UNTRUSTED = (
    "runs a program or file that is not this package's; expected --trust-plugins, if you know what "
    "it is, or your own choice of --solver"
)
_NO_GUESS = "takes no initial guess; expected only solvers that do, or *"


def solver_problems(fields: dict[str, Any], trust_plugins: bool) -> list[Problem]:
    """Solvers that do not exist, have no such setting, or cannot be asked what they are asked.

    Each is made with its settings, braces written out. Plug-in files and programs on PATH are
    refused unless they are trusted, since the file may come from anyone; none of them is loaded
    before.

    Args:
        fields: the keys of the file.
        trust_plugins: whether the file may name plug-ins and programs.
    """
    profile = fields.get("profile")
    known = profile if isinstance(profile, str) and profile in PROFILES else "default"
    problems: list[Problem] = []
    left = MOST_SPECS  # a stranger's file may list any number
    for path, spec, needs_guess in _listed(fields):
        sentences: dict[str, str] = {}  # by what makes two of them one mistake
        try:
            for name in written_out([spec], ()):
                left -= 1
                if left < 0:
                    return problems
                if sentence := _sentence(name, known, trust_plugins, needs_guess):
                    kind = _UNTRUSTED if sentence.endswith(_UNTRUSTED) else sentence
                    sentences.setdefault(kind, sentence)
        except SolverError as error:  # the spec cannot be written out
            sentences[str(error)] = str(error)
        key = ".".join(map(str, path[:-1]))
        problems += [Problem(path, f"{key}: {sentence}") for sentence in sentences.values()]
    return problems


def _sentence(name: str, profile: str, trust_plugins: bool, needs_guess: bool) -> str | None:
    """What is wrong with one spec; None if nothing is."""
    try:
        if not trust_plugins and untrusted_spec([name], profile):
            return f"{name} {_UNTRUSTED}"
        solver = describe_solver(name, profile)
    except SolverError as error:
        return str(error)
    return f"{solver.spec} {_NO_GUESS}" if needs_guess and not solver.warm else None


def _listed(fields: dict[str, Any]) -> list[tuple[KeyPath, str, bool]]:
    """The path and the text of every spec of the file, and whether it is given a guess."""
    blocks = [(("scenarios", number), block) for number, block in tables(fields)]
    guided = any("guess_lengths" in b and "solvers" not in b for _, b in blocks)
    lists: list[tuple[KeyPath, Any, bool]] = [((), fields, guided)]
    if isinstance(fields.get("first"), dict):
        lists.append((("first",), fields["first"], False))
    lists += [(path, block, "guess_lengths" in block) for path, block in blocks]
    listed = []
    for path, table, needs_guess in lists:
        specs = table.get("solvers")
        if isinstance(specs, list):
            # `*` selects the solvers that take an initial guess
            needs_guess = needs_guess and "*" not in specs
            listed += [
                ((*path, "solvers", number), spec, needs_guess)
                for number, spec in enumerate(specs)
                if isinstance(spec, str) and spec != "*"
            ]
    return listed
