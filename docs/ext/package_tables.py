"""Tables of the package's solvers, columns and experiments.

Settings of the solvers are there too.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from inspect import cleandoc

from markdown_text import code, prose, table

from dubins_study.conformance.checks import TITLES
from dubins_study.experiments.definition.experiment import packaged, read
from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES, NLP_ENGINES, names
from dubins_study.solvers.protocol import Solver
from dubins_study.solvers.registry import load, ours, registered, settings, stated_method
from dubins_study.solvers.statuses import STATUSES
from dubins_study.study.rows import schema
from dubins_study.study.tolerances import PROFILES
from dubins_study.study.words import DERIVATIVE_FREE, QP, SAMPLING, Claim

# An item of `Args:` in a docstring: names, a colon, and what they mean.
_ITEM = re.compile(r"^ {4}([a-z_0-9]+(?:, [a-z_0-9]+)*): (.*(?:\n {8}.*)*)", re.M)
# The parts of a row, in the order of its columns.
_PARTS = {
    "key": ("The cell", schema.KEY),
    "scenario": ("The scenario", schema.SCENARIO),
    "answer": ("The answer and its judgement", schema.ANSWER),
    "run": ("The run", schema.RUN),
}

_ENGINE_KINDS = {
    "nlp": NLP_ENGINES,
    "global": MINLP_ENGINES,
    "search": names(SAMPLING, DERIVATIVE_FREE),
    "qp": names(QP),
}


def solver_names() -> list[str]:
    """The package's solvers, in the order of `solvers`.

    The command is `dubins-study solvers`.
    """
    return [name for name in registered() if ours(name)]


def settings_table(argument: str) -> str:
    """Every setting of a solver.

    A row has its default, what the profiles change, and what it means. `ipopt without nlp` has
    those of one solver that another one lacks or begins otherwise.
    """
    spec, _, other = argument.partition(" without ")
    solver = load(spec)
    shared = settings(load(other)) if other else {}
    meanings = setting_meanings(type(solver))
    profiles = type(solver).profiles
    rows = []
    for name, value in settings(solver).items():
        if name in shared and shared[name] == value:
            continue
        changed = {key: change[name] for key, change in profiles.items() if name in change}
        in_profiles = ", ".join(f"{key} {code(new)}" for key, new in changed.items())
        shown = str(value).lower() if isinstance(value, bool) else value
        rows.append((code(name), code(shown), in_profiles or "–", meanings[name]))
    if not rows:
        return "It has no settings."
    return table(("setting", "default", "in a profile", "meaning"), rows)


def setting_meanings(kind: type[Solver]) -> dict[str, str]:
    """Meaning of each setting, from the docstrings.

    They are those of the class and of the classes that it extends.
    """
    meanings: dict[str, str] = {}
    for ancestor in reversed(kind.__mro__):
        if issubclass(ancestor, Solver) and ancestor is not Solver:
            _, _, items = cleandoc(ancestor.__doc__ or "").partition("Args:")
            for names, meaning in _ITEM.findall(items):
                meanings |= {name: prose(meaning) for name in names.split(", ")}
    return meanings


def solvers_table() -> str:
    """Every solver of the package.

    A row has formulation, default engine, promise and branches.
    """
    rows = []
    for name in solver_names():
        solver = load(name)
        method = stated_method(solver)
        branches = ", ".join(solver.branches)
        rows.append(
            (code(name), method.formulation, method.engine, str(solver.guarantee), branches)
        )
    head = ("solver", "formulation", "engine by default", "promise", "branches")
    return table(head, rows)


def columns_table(part: str) -> str:
    """The columns of one part of a row."""
    _, columns = _PARTS[part]
    rows = [(code(c.name), c.type, c.unit or "–", prose(c.meaning)) for c in columns]
    return table(("column", "type", "unit", "meaning"), rows)


def profiles_table() -> str:
    """Tolerances of each profile for an optimal answer."""
    rows = [
        (code(name), f"{t.gap:g}", f"{t.miss:g} R", f"{t.curvature:g} / R")
        for name, t in PROFILES.items()
    ]
    return table(("profile", "largest gap", "largest miss", "curvature excess"), rows)


def experiments_table() -> str:
    """Experiments that `run` knows by name.

    Each has its question.
    """
    rows = []
    for name in packaged():
        experiment = read(name).experiment
        rows.append((code(name), experiment.title, prose(experiment.question)))
    return table(("experiment", "title", "question"), rows)


def engine_names(kind: str) -> str:
    """Names that the setting `engine` takes.

    Each has the engine's own name.
    """
    engines = [f"{code(name)} ({prose(ENGINES[name].label)})" for name in _ENGINE_KINDS[kind]]
    return f"Names of engines: {', '.join(engines)}."


def options_table(kind: str) -> str:
    """Engine options that differ from the makers' defaults.

    A row says in which set they do; the table is of engines of one kind.
    """
    rows = []
    for name in _ENGINE_KINDS[kind]:
        options = ENGINES[name].options
        why = ENGINES[name].options.why
        equal = {k: v for k, v in options.of("equal").items() if options.always.get(k) != v}
        sets = {
            "every": (options.always, f"{why[:1].upper()}{why[1:]}."),
            "`equal`": (equal, ""),
            "`tuned`": (options.tuned, options.source),
        }
        chosen = [(where, *texts) for where, texts in sets.items() if texts[0]]
        if not chosen:
            rows.append((code(name), "–", "–", "its makers' own in every set"))
        for first, (where, values, reason) in enumerate(chosen):
            texts = ", ".join(code(f"{key}={value}") for key, value in values.items())
            rows.append(("" if first else code(name), where, texts, reason or "–"))
    return table(("`engine=`", "set", "options", "why"), rows)


def statuses_table() -> str:
    """Claim of each engine's own statuses.

    All other statuses are `failed`.
    """
    claims = [Claim.OPTIMAL, Claim.LOCAL, Claim.FEASIBLE, Claim.INFEASIBLE, Claim.LIMIT]
    rows = []
    for engine, statuses in STATUSES.items():
        texts = [", ".join(map(code, statuses.get(claim, ()))) or "–" for claim in claims]
        rows.append((code(engine), *texts))
    return table(("statuses of", *map(code, claims)), rows)


def checks_table() -> str:
    """What the conformance kit checks."""
    return table(
        ("check", "the solver ..."), [(code(n), prose(title)) for n, title in TITLES.items()]
    )


SOURCES: dict[str, Callable[..., str]] = {
    "settings": settings_table,
    "solvers": solvers_table,
    "columns": columns_table,
    "profiles": profiles_table,
    "experiments": experiments_table,
    "checks": checks_table,
    "engine-names": engine_names,
    "engine-options": options_table,
    "statuses": statuses_table,
}
