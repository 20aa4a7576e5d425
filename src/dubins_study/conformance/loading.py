"""What a solver says of itself, asked in its own process, and the check of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import is_dataclass, replace
from inspect import get_annotations
from typing import Any

from dubins_study.conformance.findings import CheckResult, Finding, Status
from dubins_study.conformance.questions import check_command
from dubins_study.experiments.code_digest import plain_settings
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.protocol import NOT_STATED, Guarantee, Solver
from dubins_study.solvers.registry import SolverError, load, settings, stated_method, unavailable
from dubins_study.solvers.reply import exception_text
from dubins_study.study.values import did_you_mean
from dubins_study.study.words import BRANCHES, FORMULATIONS

BROKEN = "the file has to load by itself: python my_solver.py must not raise"
# part of the message of a solver that does not load -> what to do, where it is not the file
_BROKEN = {
    "required positional argument": "give each setting a default, such as `n: int = 10`",
    "cannot be made": "its class is called with no arguments, and with settings; it must not raise",
}


def broken(message: str, traceback: str, spec: str) -> Finding:
    """The finding about a solver that does not load."""
    advice = next((text for part, text in _BROKEN.items() if part in message), BROKEN)
    shown = check_command(spec, "loading")
    return Finding(Status.FAIL, message, advice, command=shown, traceback=traceback)


def check(declared: dict[str, Any], title: str, spec: str) -> CheckResult:
    """Findings about the declaration of a solver that was loaded."""
    found = [*_branches(declared), *_guarantee(declared), *_texts(declared)]
    for problem, advice in declared["setting_problems"]:
        found.append(Finding(Status.NOTE, f"a spec cannot set {problem}", advice))
    if declared["no_settings"] is not None:
        names = ", ".join(declared["no_settings"])
        observed = f"it is no dataclass: {names} cannot be set" if names else "it is no dataclass"
        advice = "write @dataclass(frozen=True) above its class: its fields are then its settings"
        found.append(Finding(Status.NOTE, observed, advice))
    if not declared["frozen"]:
        advice = "write @dataclass(frozen=True): the same settings then stay the same solver"
        found.append(Finding(Status.NOTE, "its settings can be changed", advice))
    if declared["unavailable"] is not None:
        observed, advice = f"it cannot run here: {declared['unavailable']}", ""
        if declared["reason_raised"]:
            advice = "unavailable() does not raise: it returns the reason as a text, or None"
        status = Status.FAIL if declared["reason_raised"] else Status.NOTE
        found.append(Finding(status, observed, advice))
    found = [replace(one, command=check_command(spec, "loading")) for one in found]
    found.sort(key=lambda one: one.status is not Status.FAIL)
    formulation, engine = declared["method"][:2]
    return CheckResult(
        "loading", title, tuple(found), f"{declared['name']}: {formulation}, {engine}"
    )


def _branches(declared: dict[str, Any]) -> list[Finding]:
    unknown = [name for name in declared["branches"] if name not in BRANCHES]
    if not unknown and declared["branches"]:
        return []
    observed = f"branches names {unknown[0]!r}" if unknown else "branches is empty"
    return [Finding(Status.FAIL, observed, f"expected some of: {', '.join(BRANCHES)}")]


def _guarantee(declared: dict[str, Any]) -> list[Finding]:
    if declared["guarantee"] in set(Guarantee):
        return []
    observed = f"guarantee is {declared['guarantee']!r}"
    return [Finding(Status.FAIL, observed, f"expected a Guarantee: {', '.join(Guarantee)}")]


def _texts(declared: dict[str, Any]) -> list[Finding]:
    """What a comparison shows of a solver and this one leaves out."""
    found = []
    formulation, engine = declared["method"][:2]
    if (formulation, engine) == NOT_STATED[:2]:
        advice = 'add method = ("penalty", "my engine", "random"): formulation, engine, guess'
        found.append(Finding(Status.NOTE, "it does not state its method", advice))
    elif formulation not in FORMULATIONS:
        hint = did_you_mean(formulation, FORMULATIONS)
        advice = f"{hint}A row of its own is fine; the others are: {'; '.join(FORMULATIONS)}"
        observed = f"its formulation, {formulation!r}, is not one of this package's"
        found.append(Finding(Status.NOTE, observed, advice))
    if not declared["summary"]:
        advice = "add a line: summary = ..."
        found.append(Finding(Status.NOTE, "it has no summary", advice))
    return found


def declaration(solver: Solver, spec: str) -> dict[str, Any]:
    """What a solver says of itself, as plain values; a plug-in's own code answers."""
    kind = type(solver)
    return {
        "name": str(kind.name),
        "guarantee": str(kind.guarantee),
        "branches": list(kind.branches),
        "warm": bool(kind.warm),
        "packages": list(kind.packages),
        "summary": str(kind.summary),
        "method": list(stated_method(solver)),
        "keeps_limit": bool(solver.keeps_limit),
        "whole_frames": kind.solve_frame is not None,
        "settings": plain_settings(solver),
        "no_settings": _no_settings(kind),
        "frozen": not is_dataclass(kind) or kind.__dataclass_params__.frozen,
        "setting_problems": setting_problems(solver, spec),
        "unavailable": unavailable(solver),
        "reason_raised": _raises(solver.unavailable),
    }


def _no_settings(kind: type[Solver]) -> list[str] | None:
    """What looks like settings and is none for want of a dataclass; None if nothing is missing."""
    own = kind.__mro__[: kind.__mro__.index(Solver)]
    declared = {name: str(type_) for one in own for name, type_ in get_annotations(one).items()}
    fields = getattr(kind, "__dataclass_fields__", {})
    names = [
        name
        for name, type_ in declared.items()
        if name not in fields and not hasattr(Solver, name) and "ClassVar" not in type_
    ]
    return names if names or not is_dataclass(kind) else None


def _raises(function: Callable[[], object]) -> bool:
    try:
        function()
    except Exception:
        return True
    return False


_DEFAULT = "give each setting a default of type int, float, bool or str"
_TEXT = "a spec has no room for a comma, a bracket or spaces at the ends; use a word as the default"


def setting_problems(solver: Solver, spec: str) -> list[tuple[str, str]]:
    """Settings that a spec cannot set to the value that they have, each with what to do."""
    name = spec.partition("[")[0]
    problems = []
    for profile in PROFILES:
        try:
            load(spec, profile)
        except SolverError as error:
            advice = "a profile is a dict of settings that the class accepts"
            problems.append((f"the profile {profile}: {error}", advice))
    for key, value in settings(solver).items():
        if value == "":  # nothing that a spec could write
            continue
        if type(value) not in (int, float, bool, str):
            problems.append(
                (f"{key}: its default {value!r:.40} is a {type(value).__name__}", _DEFAULT)
            )
            continue
        advice = _TEXT if isinstance(value, str) else "the class must accept its own default"
        try:
            again = settings(load(f"{name}[{key}={value}]"))[key]
        except Exception as error:
            problems.append((f"{key}={value}: {exception_text(error)}", advice))
        else:
            if again != value or type(again) is not type(value):
                problems.append((f"{key}={value!r}: it comes back as {again!r}", advice))
    return problems
