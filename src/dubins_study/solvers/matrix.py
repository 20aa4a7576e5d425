"""The matrix of formulations and engines.

Each pair has the spec that asks for it, or the reason why none does.
"""

from __future__ import annotations

from collections.abc import Iterator

from dubins_study.solvers.engines import APART, ENGINES
from dubins_study.solvers.registry import SolverError, load, stated_method, unavailable
from dubins_study.study.rows.manifest import MatrixEntry
from dubins_study.study.words import (
    CONSTRAINTS,
    DERIVATIVE_FREE,
    EXACT,
    FORMULATION_LIST,
    FORMULATIONS,
    MILP,
    NLP,
    PROVEN,
    QP,
    ROOTS,
    ROUTING,
    SAMPLING,
)

_BOUNDS_ONLY = "takes bounds and no equations, of which the penalty is made"
# kind of engine -> why its engines do not read the other formulations
_REASONS = {
    EXACT: "no engine is needed for a formula",
    NLP: "reaches this engine only as Pyomo's model of (4.12)",
    PROVEN: "not asked: SCIP did not prove three segments of multiple shooting in a minute",
    SAMPLING: _BOUNDS_ONLY,
    DERIVATIVE_FREE: _BOUNDS_ONLY,
    ROOTS: "finds roots of as many equations as unknowns, minimises nothing",
    QP: "takes no nonlinear equations; turn rates are a sequence of convex programs",
    MILP: "reads linear rows only",
    CONSTRAINTS: "reads whole numbers only",
    ROUTING: "plans visits of vehicles, and reads no equations",
}


def matrix() -> list[MatrixEntry]:
    """One entry for each pair of formulation and engine.

    The entries are in the order of the formulations. Those of one formulation are in the order of
    the engines' kinds.
    """
    kinds = {"analytic": EXACT} | {name: ENGINES[name].kind for name in (*APART, *ENGINES)}
    in_order = list(_REASONS)
    entries = {}
    for name in sorted(kinds, key=lambda name: in_order.index(kinds[name])):
        for entry in _of_engine(name, kinds[name]):
            entries[entry.formulation, entry.engine] = entry
    return sorted(entries.values(), key=lambda entry: FORMULATIONS.index(entry.formulation))


def _spec(template: str, name: str) -> str:
    """The spec that asks for an engine.

    The template `nlp[engine={},model=joint]` becomes `nlp[engine=uno,model=joint]`. For `slsqp` and
    `ipopt`, which have solvers of their own, it becomes `ipopt[model=joint]`.
    """
    if name in APART and template.startswith("nlp[engine={}"):
        return template.replace("nlp[engine={}", f"{name}[").replace("[,", "[").replace("[]", "")
    return template.format(name)


def _of_engine(name: str, kind: str) -> Iterator[MatrixEntry]:
    """One entry of an engine for each formulation.

    An entry has the spec of a solver that can run here, or else the reason why there is none.
    """
    solvers = {}
    for formulation in FORMULATION_LIST:
        if kind not in formulation.specs:
            continue
        spec = _spec(formulation.specs[kind], name)
        try:
            solvers[formulation.name] = spec, load(spec)
        except SolverError:  # the engine is not one of this solver's
            continue
    # formulations without a solver show the name that the engine has in its first solver
    label = next(stated_method(solver).engine for _, solver in solvers.values())
    for formulation in FORMULATION_LIST:
        entry = solvers.get(formulation.name)
        reason: str | None = formulation.reasons.get(kind, _REASONS[kind])
        engine = label
        usable_spec = None
        if entry is not None:
            spec, solver = entry
            reason = unavailable(solver)
            engine = stated_method(solver).engine  # the exact methods have several names
            if reason is None:
                usable_spec = spec
        yield MatrixEntry(
            formulation=formulation.name,
            engine=engine,
            kind=kind,
            spec=usable_spec,
            reason=reason,
        )
