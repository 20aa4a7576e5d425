"""Names that a shell completes, read without importing what they name."""

from __future__ import annotations

from dubins_study.study.words import BRANCHES

SOLVER_GROUP = "dubins_study.solvers"  # `solvers.registry.GROUP`, without the time of its import


def branches(incomplete: str) -> list[str]:
    """The branches that begin with a text."""
    return _beginning(incomplete, BRANCHES)


def profiles(incomplete: str) -> list[str]:
    """The profiles that begin with a text."""
    return _beginning(incomplete, ("default", "fast", "accurate"))


def solvers(incomplete: str) -> list[str]:
    """The registered solvers, plug-ins included, whose names begin with a text."""
    from importlib.metadata import entry_points

    return _beginning(incomplete, sorted(point.name for point in entry_points(group=SOLVER_GROUP)))


def experiments(incomplete: str) -> list[str]:
    """The packaged experiments whose names begin with a text."""
    from importlib.resources import files

    folder = files("dubins_study.experiments")
    names = [file.name for file in folder.iterdir() if file.name.endswith(".toml")]
    return _beginning(incomplete, sorted(name.removesuffix(".toml") for name in names))


def _beginning(text: str, names: list[str] | tuple[str, ...]) -> list[str]:
    return [name for name in names if name.startswith(text)]
