"""Every formulation with every engine: the spec that asks for the pair, or why nobody can."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from dubins_study.solvers.registry import SolverError, load, stated_method, unavailable
from dubins_study.study.rows.manifest import MatrixEntry
from dubins_study.study.words import FORMULATIONS


class _Family(NamedTuple):
    """Engines that read the same formulations.

    Args:
        kind: heads the family in tables.
        specs: formulation -> the spec that asks an engine for it; `{}` is the engine's name.
        reasons: formulation -> why the family cannot read it; `other` for those not named.
        engines: their names in specs.
    """

    kind: str
    specs: Mapping[str, str]
    reasons: Mapping[str, str]
    engines: tuple[str, ...]


_FORMULA = {"closed form": "a formula, which needs no engine"}
_PAPER_NLP = {
    "one NLP a word": "nlp[engine={}]",
    "joint NLP, LRS": "nlp[engine={},model=joint,order=LRS]",
    "joint NLP, RLS": "nlp[engine={},model=joint,order=RLS]",
    "joint NLP, both orders": "nlp[engine={},model=joint]",
}
_TRANSCRIBED = {
    "turn rates": "turn-rates[engine={}]",
    "Radau collocation": "collocation[engine={}]",
    "multiple shooting": "multiple-shooting[engine={}]",
}
_NO_NLP = _FORMULA | {
    "Pontryagin's system": "a square system of equations: there is nothing to minimise",
    "grid of headings": "has integer variables",
    "disjunction": "has integer variables",
    "penalty": "has a kink wherever a path arrives: made for engines without derivatives",
    "other": "reaches this engine only as Pyomo's model of (4.12)",
}
_GLOBAL = {
    "one NLP a word": "global-nlp[engine={},model=words]",
    "joint NLP, LRS": "global-nlp[engine={},order=LRS]",
    "joint NLP, RLS": "global-nlp[engine={},order=RLS]",
    "joint NLP, both orders": "global-nlp[engine={}]",
    "grid of headings": "heading-milp[engine={}]",
    "disjunction": "disjunctive[engine={}]",
}
_NO_GLOBAL = _FORMULA | {
    "Pontryagin's system": "a square system of equations: there is nothing to minimise",
    "penalty": "the same as the joint NLP, with equations that these engines take as they are",
    "other": "not asked: SCIP did not prove three segments of multiple shooting in a minute",
}


def _families() -> Iterator[_Family]:
    """The families in the order of tables. Adapters are loaded here, their libraries are not."""
    from dubins_study.solvers.indirect.shooting import ROOTS
    from dubins_study.solvers.minlp_engines.table import ENGINES as MINLP_ENGINES
    from dubins_study.solvers.nlp_engines.table import ENGINES
    from dubins_study.solvers.stochastic.engines import ENGINES as SEARCHES

    no_engine = {"other": "no engine is needed for a formula"}
    yield _Family("exact", {"closed form": "analytic"}, no_engine, ("analytic",))
    for name in ("slsqp", "ipopt"):  # which have solvers of their own for the paper's model
        own = {key: spec.replace("nlp[engine={}", name + "[") for key, spec in _PAPER_NLP.items()}
        own = {key: spec.replace("[]", "").replace("[,", "[") for key, spec in own.items()}
        yield _Family("local NLP", own | _TRANSCRIBED, _NO_NLP, (name,))
    others = tuple(name for name in ENGINES if name not in ("slsqp", "ipopt"))
    yield _Family("local NLP", _PAPER_NLP | _TRANSCRIBED, _NO_NLP, (*others, "knitro"))
    yield _Family("global, with proof", _GLOBAL, _NO_GLOBAL, tuple(MINLP_ENGINES))
    bounds_only = _FORMULA | {
        "other": "takes bounds and no equations, of which the penalty is made"
    }
    for kind, guided in (("stochastic or direct search", False), ("derivative-free, local", True)):
        names = tuple(name for name, entry in SEARCHES.items() if entry.guided is guided)
        yield _Family(kind, {"penalty": "penalty[engine={}]"}, bounds_only, names)
    roots = {"Pontryagin's system": "shooting[root={}]"}
    no_roots = _FORMULA | {
        "other": "finds roots of as many equations as unknowns, minimises nothing"
    }
    yield _Family("roots", roots, no_roots, ROOTS)
    qps = {"turn rates": "turn-rate-qp[engine={}]", "grid of headings": "heading-milp[engine={}]"}
    no_qp = _FORMULA | {
        "other": "takes no nonlinear equations; turn rates are a sequence of convex programs",
        "grid of headings": "has integer variables",
    }
    yield _Family("QP and MILP", qps, no_qp, ("piqp", "clarabel", "osqp", "highs"))


def matrix() -> list[MatrixEntry]:
    """One entry for each pair, formulation by formulation; engines in the order of families."""
    entries = {(entry.formulation, entry.engine): entry for entry in _entries()}
    order = {name: place for place, name in enumerate(FORMULATIONS)}
    return sorted(entries.values(), key=lambda entry: order[entry.formulation])


def _entries() -> Iterator[MatrixEntry]:
    for family in _families():
        for name in family.engines:
            yield from _of_engine(family, name)


def _of_engine(family: _Family, name: str) -> Iterator[MatrixEntry]:
    """The entries of one engine."""
    solvers = {}
    for formulation, spec in family.specs.items():
        asked_spec = spec.format(name)
        try:
            solvers[formulation] = asked_spec, load(asked_spec)
        except SolverError:  # the engine is not one of this solver's
            continue
    label = next(stated_method(solver).engine for _, solver in solvers.values())
    for formulation in FORMULATIONS:
        asked = solvers.get(formulation)
        if asked is None:
            why = family.reasons.get(formulation, family.reasons.get("other", ""))
            yield MatrixEntry(formulation=formulation, engine=label, kind=family.kind, reason=why)
            continue
        spec, solver = asked
        reason = unavailable(solver)
        yield MatrixEntry(
            formulation=formulation,
            engine=label,
            kind=family.kind,
            spec=spec if reason is None else None,
            reason=reason,
        )
