"""Wrong solvers of an invalid file, so that they are named together with its other mistakes."""

from __future__ import annotations

from typing import Any

from dubins_study.experiments.definition.messages import Problem
from dubins_study.experiments.definition.spec_braces import MOST_SPECS, written_out
from dubins_study.experiments.definition.toml_lines import KeyPath
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.registry import SolverError, load, ours


def solver_problems(fields: dict[str, Any]) -> list[Problem]:
    """What is wrong with the solvers of this package that an invalid file names.

    Each is made with its settings, braces written out. Plug-ins are left for the plan of a run,
    once the file is valid: their code has to be trusted first.
    """
    profile = fields.get("profile")
    known = profile if isinstance(profile, str) and profile in PROFILES else "default"
    problems: list[Problem] = []
    left = MOST_SPECS  # a stranger's file may list any number
    for path, spec in _listed(fields):
        try:
            for name in written_out([spec], ()):
                left -= 1
                if left < 0:
                    return problems
                if ".py:" not in name and ours(name):
                    load(name, known)
        except SolverError as error:
            problems.append(Problem(path, f"{'.'.join(map(str, path[:-1]))}: {error}"))
    return problems


def _listed(fields: dict[str, Any]) -> list[tuple[KeyPath, str]]:
    """The path and the text of every spec of the file."""
    tables: list[tuple[KeyPath, Any]] = [((), fields), (("first",), fields.get("first"))]
    blocks = fields.get("scenarios")
    if isinstance(blocks, list):
        tables += [(("scenarios", number), block) for number, block in enumerate(blocks)]
    lists = (
        ((*path, "solvers"), table.get("solvers"))
        for path, table in tables
        if isinstance(table, dict)
    )
    return [
        ((*path, number), spec)
        for path, specs in lists
        if isinstance(specs, list)
        for number, spec in enumerate(specs)
        if isinstance(spec, str) and spec != "*"
    ]
