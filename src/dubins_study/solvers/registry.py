"""Solvers by name. Nothing is imported until a solver is asked for."""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.protocol import AnySolver

GROUP = "dubins_study.solvers"
_PROMISED = ("name", "method", "guarantee", "branches", "warm", "packages", "summary")
_SPEC = re.compile(r"(?P<name>[^\[\]]+?)(?:\[(?P<settings>[^\[\]]*)\])?")


class SolverError(DubinsStudyError, ValueError):
    """A solver that does not exist, does not keep the promise, or has no such setting."""


class Entry(NamedTuple):
    """One line of `dubins-study solvers`."""

    name: str
    method: str
    guarantee: str
    branches: tuple[str, ...]
    summary: str
    settings: dict[str, Any]
    reason: str | None  # why it is not available; None when it is


@cache
def _registered() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda p: p.name)}


def ours(spec: str) -> bool:
    """Whether a spec, sound or not, could name no other code than this package's own."""
    name = spec.partition("[")[0].strip() if isinstance(spec, str) else ""
    point = _registered().get(name)
    if point is None:
        return ".py:" not in name
    return point.dist is not None and point.dist.name == "dubins-study"


def registered() -> list[str]:
    """The names of all solvers, available or not."""
    return list(_registered())


def available() -> list[str]:
    """The names of the solvers that can run here."""
    return [name for name in registered() if _entry(name).reason is None]


def entries() -> list[Entry]:
    """Every registered solver: what it is and, if it cannot run here, why.

    A backend that reaches other people's solvers by a setting names such specs as its `variants`;
    each is a line of its own.
    """
    found = []
    for name in registered():
        found.append(_entry(name))
        if found[-1].method:
            found += [_entry(spec) for spec in getattr(_kind(name), "variants", ())]
    return found


def _entry(name: str) -> Entry:
    try:
        solver = load(name)
    except SolverError as error:
        return Entry(name, "", "", (), "", {}, str(error))
    kind = type(solver)
    return Entry(
        name,
        kind.method,
        str(kind.guarantee),
        kind.branches,
        kind.summary,
        settings(solver),
        unavailable(solver),
    )


def unavailable(solver: AnySolver) -> str | None:
    """Why a solver cannot run here, or None; one that cannot even say so is unavailable."""
    try:
        return solver.unavailable()
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way; it is a reason
        return f"asking whether it is available raised {type(error).__name__}: {error}"


def settings(solver: AnySolver) -> dict[str, Any]:
    """A solver's settings and their values."""
    if not is_dataclass(solver):
        return {}
    return {field.name: getattr(solver, field.name) for field in fields(solver)}


def canonical(spec: str, profile: str = "default") -> str:
    """The spec as rows write it: settings in the order of their declaration.

    Those are left out that the solver has under the profile anyway.

    Raises:
        SolverError: as `load`.
    """
    name, given = _parse(spec)
    kind = _kind(name)
    values = _convert(name, kind, given)
    defaults = settings(load(name, profile))
    changed = [f"{k}={values[k]}" for k in defaults if k in values and values[k] != defaults[k]]
    return f"{name}[{','.join(changed)}]" if changed else name


def load(spec: str, profile: str = "default") -> AnySolver:
    """The solver of a spec.

    Args:
        spec: `ipopt`, `turn-rate-qp[n=50,engine=piqp]`, or `file.py:Class` with or without
            settings.
        profile: settings that the solver keeps under this name come first, those of the spec on
            top of them.

    Raises:
        SolverError: naming the solver, setting or value, and what was expected.
    """
    name, given = _parse(spec)
    kind = _kind(name)
    values = {**getattr(kind, "profiles", {}).get(profile, {}), **_convert(name, kind, given)}
    try:
        solver: AnySolver = kind(**values)
    except ValueError as error:
        raise SolverError(f"solver {spec!r}: {error}") from None
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way
        raise SolverError(f"solver {spec!r} cannot be made: {error!r}") from error
    return solver


def _parse(spec: str) -> tuple[str, dict[str, str]]:
    if not isinstance(spec, str):
        raise SolverError(f"solver is {spec!r}; expected a text, name[setting=value]")
    match = _SPEC.fullmatch(spec.strip())
    if match is None:
        raise SolverError(f"solver {spec!r} does not parse; expected name or name[setting=value]")
    given = {}
    for item in filter(None, (match["settings"] or "").split(",")):
        key, equals, value = (part.strip() for part in item.partition("="))
        if not (key and equals and value):
            raise SolverError(f"solver {spec!r}: {item!r} does not parse; expected setting=value")
        if key in given:
            raise SolverError(f"solver {spec!r}: {key} is given twice; expected each setting once")
        given[key] = value
    return match["name"].strip(), given


def _kind(name: str) -> type[Any]:
    point = _registered().get(name)
    if point is None:
        if ".py:" in name:
            return _from_file(name)
        raise SolverError(f"no solver named {name!r}; choose one of: {', '.join(registered())}")
    try:
        kind = point.load()
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way; it is a reason
        raise SolverError(f"solver {name!r} cannot be imported: {error}") from error
    return _kept_promise(name, kind)


@cache
def _from_file(name: str) -> type[Any]:
    file, _, class_name = name.rpartition(":")
    path = FilePath(file)
    if not path.is_file():
        raise SolverError(f"solver {name!r}: no file {file!r}; expected file.py:Class")
    digest = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    module_name = f"dubins_study_plugin_{path.stem}_{digest}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # dataclasses look their module up by its name
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # the user's own program; whatever it raises
        del sys.modules[module_name]
        raise SolverError(f"solver {name!r}: {file} fails: {error!r}") from error
    if not hasattr(module, class_name):
        raise SolverError(f"solver {name!r}: {file} has no class {class_name!r}")
    return _kept_promise(name, getattr(module, class_name))


def _kept_promise(name: str, kind: Any) -> type[Any]:
    wanted = (*_PROMISED, "unavailable", "build", "solve")
    missing = [attribute for attribute in wanted if not hasattr(kind, attribute)]
    if not isinstance(kind, type) or missing:
        lack = f"has no {missing[0]!r}" if missing else "is not a class"
        raise SolverError(
            f"solver {name!r} {lack}; expected the promise of dubins_study.solvers.protocol"
        )
    for attribute in ("branches", "packages"):
        texts = getattr(kind, attribute)
        if not isinstance(texts, tuple) or not all(isinstance(text, str) for text in texts):
            raise SolverError(f"solver {name!r}: {attribute} is {texts!r}; expected texts, a tuple")
    profiles = getattr(kind, "profiles", {})
    if not isinstance(profiles, dict) or not all(isinstance(p, dict) for p in profiles.values()):
        raise SolverError(f"solver {name!r}: profiles is {profiles!r}; expected a dict of dicts")
    return kind


def _convert(name: str, kind: type[Any], given: dict[str, str]) -> dict[str, Any]:
    """The settings' texts as values of the types that the defaults have."""
    if not given:
        return {}
    defaults = settings(kind())
    values = {}
    for key, text in given.items():
        if key not in defaults:
            known = ", ".join(defaults) or "none"
            raise SolverError(f"solver {name!r} has no setting {key!r}; it has: {known}")
        wanted = type(defaults[key])
        try:
            values[key] = _BOOLEANS[text.lower()] if wanted is bool else wanted(text)
        except (KeyError, ValueError):
            raise SolverError(
                f"solver {name!r}: {key} is {text!r}; expected {wanted.__name__}, "
                f"such as {defaults[key]}"
            ) from None
    return values


_BOOLEANS = {"true": True, "false": False}
