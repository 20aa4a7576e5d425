"""The code digest: changes when solvers must run again.

A solver lies in a room: a folder of `solvers`, or a module directly in `solvers`. Its digest covers
the code of the whole room, of the attempt that judges an answer, and of `study`. It also covers
every room of `solvers` and `asking` that the room's code names. Rooms are found by their dotted
names in the code. An import inside a function therefore counts, like one at the top of a file.
Comments, docstrings and layout do not.
"""

from __future__ import annotations

import ast
import hashlib
import json
import math
import os
import re
import sys
from collections.abc import Iterable
from functools import cache
from itertools import chain
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.provenance import versions_of
from dubins_study.solvers.protocol import Solver
from dubins_study.solvers.registry import canonical, load, settings
from dubins_study.study.specs import name_of, plugin_file

_DIGEST_DIGITS = 12
_PACKAGE = FilePath(__file__).parents[1]
_ROOM_NAME = re.compile(rb"dubins_study\.((?:solvers|asking)\.\w+)")
_JUDGE = "asking.attempt"  # the room that judges the answers of all solvers
_ADDRESS = re.compile(r" at 0x[0-9a-fA-F]+")

# Path of a file, as it enters the hash -> its syntax.
Sources = dict[str, bytes]


@cache
def code_digest(spec: str, profile: str = "default") -> str:
    """The digest in the column `code_digest`: 12 hexadecimal digits."""
    solver = load(spec, profile)
    description = {
        "spec": canonical(spec, profile),
        "settings": plain_settings(solver),
        "packages": versions_of(tuple(solver.packages)),
    }
    digest = hashlib.sha256(json.dumps(description, sort_keys=True).encode("utf-8", "replace"))
    for name, source in sorted(solver_sources(spec, type(solver)).items()):
        digest.update(f"\0{name}\0".encode("utf-8", "replace") + source)
    return digest.hexdigest()[:_DIGEST_DIGITS]


def plain_settings(solver: Solver) -> dict[str, Any]:
    """A solver's settings as values that JSON can hold.

    Values of other types become text.
    """
    return {name: _plain(value) for name, value in settings(solver).items()}


def _plain(value: Any) -> Any:
    # a member of an enum may be a str too, but is of another type
    if value is None or type(value) in (str, int, bool):
        return value
    if type(value) is float and math.isfinite(value):
        return value
    return _ADDRESS.sub("", str(value))


def solver_sources(spec: str, solver_class: type[Any]) -> Sources:
    """The source files on which a solver's rows depend.

    These are the files of the solver's room, or a plug-in's file or whole package. Rooms that they
    name, the room that judges, and `study` are included.
    """
    module = solver_class.__module__
    plugin = plugin_file(name_of(spec))
    if plugin is not None:
        sources = {"plug-in": _read(FilePath(plugin.file))}  # which is loaded alone
    elif module.startswith("dubins_study.solvers."):
        sources = dict(_room(".".join(module.split(".")[1:3])))
    else:
        sources = _installed_plugin(module.partition(".")[0])
    sources |= _room(_JUDGE)
    return _with_named_rooms(sources) | study_sources()


def _with_named_rooms(sources: Sources) -> Sources:
    """The sources with all rooms that they name.

    Rooms that those rooms name are included, and so on.
    """
    complete = dict(sources)
    unread = list(sources.values())
    while unread:
        for room in set(_ROOM_NAME.findall(unread.pop())):
            for file, source in _room(room.decode()).items():
                if file not in complete:
                    complete[file] = source
                    unread.append(source)
    return complete


@cache
def _room(name: str) -> Sources:
    """All modules of a room, such as `solvers.route`.

    Empty if no room has that name.
    """
    place = _PACKAGE.joinpath(*name.split("."))
    files = [place.with_suffix(".py"), *place.rglob("*.py")]
    return _read_all(_PACKAGE, (file for file in files if file.is_file()))


@cache
def study_sources() -> Sources:
    """All modules of `study`, which judges every answer.

    The modules of the results format are left out.
    """
    files = (_PACKAGE / "study").rglob("*.py")
    return _read_all(_PACKAGE, (file for file in files if file.parent.name != "rows"))


def _installed_plugin(package_name: str) -> Sources:
    """All modules of an installed plug-in.

    `package_name` is the entry point's top-level package, or its single module.
    """
    package = sys.modules[package_name]
    folders = [FilePath(folder) for folder in getattr(package, "__path__", ())]
    files = list(chain.from_iterable(folder.rglob("*.py") for folder in folders))
    module_file = FilePath(str(package.__file__))
    root = module_file.parent
    if folders:
        root = folders[0].parent
    return _read_all(root, files or [module_file])


def _read_all(root: FilePath, files: Iterable[FilePath]) -> Sources:
    return {FilePath(os.path.relpath(file, root)).as_posix(): _read(file) for file in files}


@cache
def _read(file: FilePath) -> bytes:
    """The code of a file, without comments and docstrings.

    A file that is not Python gives its bytes.
    """
    content = file.read_bytes()
    try:
        tree = ast.parse(content)
    except (SyntaxError, ValueError):  # a module that is not imported may be anything
        # git may check text files out with other line ends on another system
        return content.replace(b"\r\n", b"\n")
    text = ast.unparse(_Bare().visit(tree))
    return text.encode("utf-8", "backslashreplace")


class _Bare(ast.NodeTransformer):
    """Removes docstrings and other statements of a constant alone.

    `from a.b import c` becomes `import a.b.c`, so that a room is found by its dotted name.
    """

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.Import:
        whole = [ast.alias(f"{node.module}.{each.name}", each.asname) for each in node.names]
        return ast.Import(whole)

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        if isinstance(node.value, ast.Constant):
            return None
        return node
