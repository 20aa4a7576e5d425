"""The registry: solvers by name.

Nothing is imported until a solver is needed.
"""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path as FilePath
from traceback import format_exception_only
from typing import Any, NamedTuple, TypeGuard

from dubins_study.solvers.protocol import Method, Solver
from dubins_study.study.specs import PluginFile, name_of, parse_spec, plugin_file
from dubins_study.study.specs import SolverError as SolverError
from dubins_study.study.values import did_you_mean, number_of_text
from dubins_study.study.words import NEEDS

GROUP = "dubins_study.solvers"


class Entry(NamedTuple):
    """One line of `dubins-study solvers`."""

    name: str
    formulation: str
    engine: str
    guarantee: str
    takes: tuple[str, ...]
    branches: tuple[str, ...]
    summary: str
    settings: dict[str, Any]
    reason: str | None  # why it is not available; None if it is


@cache
def _registered() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda p: p.name)}


def ours(spec: str) -> bool:
    """Whether a spec only names this package's code.

    The spec may be invalid. An unknown name counts as ours, since it runs nobody else's code.
    """
    name = ""
    if isinstance(spec, str):
        name = name_of(spec)
    return _our_name(name)


@cache  # reading the name of a distribution takes longer than a quick solve
def _our_name(name: str) -> bool:
    point = _registered().get(name)
    if point is None:
        return plugin_file(name) is None
    return point.dist is not None and point.dist.name == "dubins-study"


def registered() -> list[str]:
    """The names of all solvers, available or not."""
    return list(_registered())


def registered_name(kind: type[Solver]) -> str | None:
    """The name that a class is registered under.

    None if it is not registered.
    """
    place = f"{kind.__module__}:{kind.__qualname__}"
    return next((name for name, point in _registered().items() if point.value == place), None)


def available_solvers() -> list[str]:
    """The names of the solvers that can run here."""
    return [name for name in registered() if _entry(name).reason is None]


def entries() -> list[Entry]:
    """Every registered solver, each followed by its `variants`.

    If a solver cannot be loaded, its entry has only the reason, and no variants follow.
    """
    listed = []
    for name in registered():
        listed.append(_entry(name))
        if listed[-1].formulation:
            listed += [_entry(spec) for spec in _kind(name).variants]
    return listed


def entry(spec: str) -> Entry:
    """The description of a spec's solver.

    If the solver cannot run here, its `reason` says why.
    """
    load(spec)
    return _entry(spec)


def _entry(name: str) -> Entry:
    # a solver that cannot be loaded has only a name and a reason
    try:
        solver = load(name)
    except SolverError as error:
        return Entry(
            name,
            formulation="",
            engine="",
            guarantee="",
            takes=(),
            branches=(),
            summary="",
            settings={},
            reason=str(error),
        )
    kind = type(solver)
    method = stated_method(solver)
    return Entry(
        name,
        formulation=method.formulation,
        engine=method.engine,
        guarantee=str(kind.guarantee),
        takes=tuple(need for need in NEEDS if need in kind.takes),
        branches=kind.branches,
        summary=kind.summary,
        settings=settings(solver),
        reason=unavailable(solver),
    )


# the reason begins like this if a solver's `unavailable` raises
UNKNOWN = "asking whether it is available raised"


def unavailable(solver: Solver) -> str | None:
    """The reason why a solver cannot run, or None.

    A solver whose own method `unavailable` raises cannot run.
    """
    try:
        return solver.unavailable()
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way; it is a reason
        return f"{UNKNOWN} {type(error).__name__}: {error}"


def reported_versions(solver: Solver) -> dict[str, str]:
    """Versions of the libraries inside a solver's packages.

    The keys are the libraries' names. If the solver's own method raises, the result names the
    exception: {"library_versions": "raised OSError"}. Call this in the process that solves, since
    loading a library may take long or fail.
    """
    try:
        return {str(name): str(text) for name, text in dict(solver.library_versions()).items()}
    except Exception as error:  # a plug-in may fail in any way
        return {"library_versions": f"raised {type(error).__name__}"}


def stated_method(solver: Solver) -> Method:
    """The `Method` that a solver states, checked.

    A plain tuple becomes a `Method`. `presolve` is read from the solver itself. A SolverError tells
    that the statement is no tuple of texts.
    """
    stated: Any = solver.method
    method = None
    with suppress(TypeError, ValueError):
        if isinstance(stated, tuple):
            method = _with_floats(Method(*stated))
    if method is None or not _are_texts((method.formulation, method.engine, method.guess)):
        raise SolverError(
            f"solver {solver.name!r}: method is {stated!r:.80}; expected a tuple of texts: "
            "formulation, engine and, if there is one, the kind of initial guess"
        )
    return method._replace(presolve=solver.presolve is True)


def _with_floats(method: Method) -> Method:
    """The method with its numbers as floats."""
    if method.tolerance is not None:
        method = method._replace(tolerance=float(method.tolerance))
    if method.proves is not None:
        method = method._replace(proves=float(method.proves))
    return method


def settings(solver: Solver) -> dict[str, Any]:
    """A solver's settings and their values."""
    if not is_dataclass(solver):
        return {}
    return {field.name: getattr(solver, field.name) for field in fields(solver)}


def canonical(spec: str, profile: str = "default") -> str:
    """The spec as rows write it.

    Settings stand in the order of the class. Those with the profile's values are left out:
    `turn-rate-qp[mesh=graded,n=50]` becomes `turn-rate-qp[mesh=graded]`. Settings that the class
    lists in `always_named` are written whatever their values.
    """
    name, texts = parse_spec(spec)
    kind = _kind(name)
    defaults = settings(load(name, profile))
    values = defaults | _convert(name, kind, texts)
    changed = [
        f"{key}={value}"
        for key, value in values.items()
        if value != defaults[key] or key in kind.always_named
    ]
    if not changed:
        return name
    return f"{name}[{','.join(changed)}]"


def load(spec: str, profile: str = "default") -> Solver:
    """Load the solver of a spec.

    A spec is `ipopt`, `turn-rate-qp[n=50,engine=piqp]` or `file.py:Class`, for example. The
    settings of the spec replace those of the profile. A SolverError names the mistake.
    """
    name, texts = parse_spec(spec)
    kind = _kind(name)
    try:
        values = {**kind.profiles.get(profile, {}), **_convert(name, kind, texts)}
        solver = kind(**values)
        stated_method(solver)
        return solver
    except SolverError:
        raise
    except ValueError as error:
        raise SolverError(f"solver {spec!r}: {error}") from None
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way
        raise SolverError(f"solver {spec!r} cannot be made: {error!r}") from error


def _kind(name: str) -> type[Solver]:
    """The class of a registered name or of `file.py:Class`."""
    point = _registered().get(name)
    if point is None:
        if file := plugin_file(name):
            return _from_file(name, file)
        known = registered()
        if name.endswith(".py"):
            raise SolverError(f"solver {name!r} is a file; expected {name}:Class")
        raise SolverError(
            f"no solver named {name!r}; {did_you_mean(name, known)}choose one of: "
            f"{', '.join(known)}, or give file.py:Class; `dubins-study solvers` tells what each is"
        )
    try:
        kind = point.load()
    except (Exception, SystemExit) as error:  # a plug-in may fail in any way; it is a reason
        raise SolverError(f"solver {name!r} cannot be imported: {error}") from error
    return _checked(name, kind)


def _error_text(error: BaseException) -> str:
    """An exception as text.

    The text of a syntax error has the file, the line and the caret below it.
    """
    *place, last = format_exception_only(error)
    return "\n".join([last.strip(), "".join(place).rstrip()]).rstrip()


@cache
def _from_file(name: str, plugin: PluginFile) -> type[Solver]:
    """Run a plug-in's file; return its solver class."""
    file, class_name = plugin
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
        raise SolverError(f"solver {name!r}: {file} fails: {_error_text(error)}") from error
    if not hasattr(module, class_name):
        solvers = [key for key, value in vars(module).items() if _is_solver(value)]
        has = ", ".join(solvers) or "no class that extends Solver"
        raise SolverError(f"solver {name!r}: {file} has no class {class_name!r}; it has: {has}")
    return _checked(name, getattr(module, class_name))


def _is_solver(value: object) -> TypeGuard[type[Solver]]:
    """Whether a value is a class that extends `Solver`."""
    return isinstance(value, type) and issubclass(value, Solver) and value is not Solver


def _are_texts(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(text, str) for text in value)


def _are_needs(value: Any) -> bool:
    return isinstance(value, frozenset) and value <= set(NEEDS)


def _are_profiles(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(each, dict) for each in value.values())


# attribute of a class -> the test of its value, and the text of the expected value
_DECLARED = {
    "branches": (_are_texts, "texts, a tuple"),
    "packages": (_are_texts, "texts, a tuple"),
    "takes": (_are_needs, f"a frozenset of: {', '.join(NEEDS)}"),
    "profiles": (_are_profiles, "a dict of dicts"),
}


def _checked(name: str, kind: Any) -> type[Solver]:
    """The class, if it is a complete solver.

    It must extend `Solver` and follow that class's docstring.
    """
    if not _is_solver(kind) or not kind.name or kind.solve is Solver.solve:
        raise SolverError(
            f"solver {name!r} is no solver; expected a frozen dataclass class Name(Solver) that "
            "extends dubins_study.Solver, with a name and solve(question, limit)"
        )
    for attribute, (holds, expected) in _DECLARED.items():
        value = getattr(kind, attribute)
        if not holds(value):
            raise SolverError(f"solver {name!r}: {attribute} is {value!r}; expected {expected}")
    return kind


def _convert(name: str, kind: type[Solver], texts: dict[str, str]) -> dict[str, Any]:
    """The settings given as texts, as values by name.

    A value has the type of the setting's default.
    """
    if not texts:
        return {}
    defaults = settings(kind())
    values = {}
    for key, text in texts.items():
        if key not in defaults:
            known = ", ".join(defaults) or "none"
            near = did_you_mean(key, defaults)
            raise SolverError(f"solver {name!r} has no setting {key!r}; {near}it has: {known}")
        value_type = type(defaults[key])
        try:
            if value_type in (int, float):
                number_of_text(text)
            if value_type is bool:
                values[key] = _BOOLEANS[text.lower()]
            else:
                values[key] = value_type(text)
        except (KeyError, TypeError, ValueError):  # no type of a number or text takes the text
            raise SolverError(
                f"solver {name!r}: {key} is {text!r}; expected {value_type.__name__}, "
                f"such as {defaults[key]}"
            ) from None
    return values


_BOOLEANS = {"true": True, "false": False}
