"""Wrong solvers of an invalid file, so that they are named together with its other mistakes."""

from __future__ import annotations

import re
from typing import Any

from dubins_study.experiments.definition.messages import Problem
from dubins_study.experiments.definition.toml_lines import KeyPath
from dubins_study.solvers.registry import SolverError, canonical, ours

# A spec without plug-ins, `*` and braces.
_PLAIN_SPEC = re.compile(r"[a-z][a-z0-9-]{0,40}(\[[\w=.,+-]{0,200}\])?")


def solver_problems(fields: dict[str, Any]) -> list[Problem]:
    """What is wrong with the solvers of this package that an invalid file names plainly.

    Plug-ins, `*` and braces are checked when a run is planned, once the file is valid.
    """
    tables: list[tuple[KeyPath, Any]] = [((), fields), (("first",), fields.get("first"))]
    blocks = fields.get("scenarios")
    if isinstance(blocks, list):
        tables += [(("scenarios", number), block) for number, block in enumerate(blocks)]
    problems = []
    for path, table in tables:
        specs = table.get("solvers") if isinstance(table, dict) else None
        for number, spec in enumerate(specs if isinstance(specs, list) else ()):
            if isinstance(spec, str) and _PLAIN_SPEC.fullmatch(spec) and ours(spec):
                try:
                    canonical(spec)
                except SolverError as error:
                    key = ".".join(map(str, (*path, "solvers")))
                    problems.append(Problem((*path, "solvers", number), f"{key}: {error}"))
    return problems
