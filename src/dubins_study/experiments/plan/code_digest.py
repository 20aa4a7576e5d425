"""What makes a row: a digest of a solver's code, its settings and its libraries' versions."""

from __future__ import annotations

import ast
import hashlib
import json
import math
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.provenance import versions_of
from dubins_study.solvers.protocol import Solver
from dubins_study.solvers.registry import canonical, load, settings

# the folder that holds our package
_ROOT = FilePath(__file__).parents[3]
_PACKAGE = "dubins_study"
_OURS = (f"{_PACKAGE}.study", f"{_PACKAGE}.solvers")
# a row holds what the check says, whatever the solver imports
_CHECK = (
    "dubins_study.study.check.verdict",
    "dubins_study.study.check.certificate",
    "dubins_study.solvers.profiles",
    "dubins_study.solvers.attempt",
)
_DIGITS = 12

# statements that import; ours stand on lines of their own (ruff's E70), and to parse only them
# takes a tenth of the time that whole modules take
_IMPORTS = re.compile(
    r"^[ \t]*(?:from[ \t]+\S+[ \t]+import[ \t]*(?:\([^)]*\)|[^(\n]*)|import[ \t][^\n]*)$", re.M
)
_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")


@cache
def code(spec: str, profile: str = "default") -> str:
    """The digest that the column `code` holds for a solver: 12 hex digits.

    Over the canonical spec with the values of all settings, the source of the solver's module, of
    the check and of every module of `study`, `solvers` and the plug-in's own package that these
    import (found by reading, so that what is imported lazily counts), and the versions of the
    solver's packages. Read once a process.

    Raises:
        SolverError: as `solvers.registry.load`.
    """
    solver = load(spec, profile)
    digest = hashlib.sha256()
    said = {
        "spec": canonical(spec, profile),
        "settings": plain_settings(solver),
        "packages": versions_of(tuple(solver.packages)),
    }
    digest.update(json.dumps(said, sort_keys=True).encode("utf-8", "replace"))
    for name, source in sorted(_sources(spec, type(solver)).items()):
        digest.update(f"\0{name}\0".encode("utf-8", "replace") + source)
    return digest.hexdigest()[:_DIGITS]


def plain_settings(solver: Solver) -> dict[str, Any]:
    """A solver's settings as JSON has them; what it cannot hold (a plug-in's) as text."""
    return {
        name: value if _is_plain(value) else _ADDRESS.sub("", str(value))
        for name, value in settings(solver).items()
    }


def _is_plain(value: object) -> bool:
    if type(value) is float:
        return math.isfinite(value)
    return value is None or type(value) in (str, int, bool)  # an enum's member may be a str


def _sources(spec: str, kind: type[Any]) -> dict[str, bytes]:
    """The source of every module that a solver's answers rest on, by the module's name."""
    roots = {_PACKAGE: _ROOT} | _own_root(kind.__module__)
    left = [*_CHECK, kind.__module__]
    found: dict[str, bytes] = {}
    file, colon, _ = spec.partition("[")[0].strip().rpartition(":")
    if colon and file.endswith(".py"):
        found["plug-in"] = _read(FilePath(file))
        # the modules and packages that lie beside it
        folder = FilePath(file).resolve().parent
        beside = [*folder.glob("*.py"), *(init.parent for init in folder.glob("*/__init__.py"))]
        roots |= {place.stem: folder for place in beside if place.stem not in roots}
        left += _imported(found["plug-in"], "", whole=True)
    while left:
        name = left.pop()
        top = name.partition(".")[0]
        elsewhere = top == _PACKAGE and not name.startswith(_OURS)
        skipped = elsewhere or top not in roots or name in found
        file_of = None if skipped else _file(roots[top], name)
        if file_of is None:
            continue
        found[name] = _read(file_of)
        package = name if file_of.name == "__init__.py" else name.rpartition(".")[0]
        left.append(name.rpartition(".")[0])
        left += _imported(found[name], package, whole=top != _PACKAGE)
    return found


def _own_root(module: str) -> dict[str, FilePath]:
    """Where an installed plug-in's package lies, by the package's name."""
    top = module.partition(".")[0]
    package = sys.modules.get(top)
    folders = list(getattr(package, "__path__", None) or ())
    file = getattr(package, "__file__", None)
    if top == _PACKAGE or not (folders or file):
        return {}
    return {top: FilePath(folders[0] if folders else str(file)).parent}


def _file(root: FilePath, module: str) -> FilePath | None:
    place = root.joinpath(*module.split("."))
    files = (place.with_name(f"{place.name}.py"), place / "__init__.py")
    return next((file for file in files if file.is_file()), None)


@cache
def _read(file: FilePath) -> bytes:
    # as git hands it out on any system
    return file.read_bytes().replace(b"\r\n", b"\n")


@cache
def _imported(source: bytes, package: str, whole: bool) -> tuple[str, ...]:
    """What a module's text imports, as dotted names, those that may be mere attributes included."""
    text = source.decode("utf-8", "replace")
    try:
        tree = ast.parse(text if whole else _only_imports(text))
    except (SyntaxError, ValueError):
        tree = ast.parse(source)
    return tuple(_names(tree, package))


def _only_imports(text: str) -> str:
    return "\n".join(match.strip() for match in _IMPORTS.findall(text))


def _names(tree: ast.Module, package: str) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*(above if node.level else ()), *filter(None, [node.module])])
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)
