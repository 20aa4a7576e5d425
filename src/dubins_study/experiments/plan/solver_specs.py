"""The solvers that an experiment names: `*` for all of them, `{a,b}` for several settings."""

from __future__ import annotations

from dubins_study.experiments.definition.spec_braces import written_out
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.solvers.registry import ours, registered


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
