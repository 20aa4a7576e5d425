"""The table of formulations and engines is right.

It is whole, and each pair is what it says.
"""

import pytest

from dubins_study.solvers.matrix import matrix
from dubins_study.solvers.registry import load, stated_method, unavailable
from dubins_study.study.words import EXACT, FORMULATIONS


@pytest.fixture(scope="module")
def entries():
    return matrix()


def test_every_formulation_has_every_engine(entries):
    """Every formulation has every engine.

    Formulations without an engine have one line together.
    """
    engines = {entry.engine for entry in entries if entry.kind != EXACT}
    posed = [entry for entry in entries if entry.kind != EXACT]

    assert len(posed) == len(FORMULATIONS) * len(engines)
    assert len(entries) == len(posed) + len(FORMULATIONS)
    assert {(entry.formulation, entry.engine) for entry in posed} == {
        (formulation, engine) for formulation in FORMULATIONS for engine in engines
    }
    assert len(engines) >= 15


def test_a_pair_is_asked_or_has_a_reason(entries):
    for entry in entries:
        assert bool(entry.spec) != bool(entry.reason), entry


def test_the_spec_of_a_pair_is_that_pair(entries):
    """The spec of a pair is that pair.

    The spec's solver names the pair's formulation and engine, and can run here.
    """
    for entry in entries:
        if entry.spec is None:
            continue
        solver = load(entry.spec)
        assert stated_method(solver)[:2] == (entry.formulation, entry.engine)
        assert unavailable(solver) is None


def test_every_formulation_and_every_engine_is_asked_somewhere(entries):
    """Every formulation and engine is asked somewhere.

    No formulation is without an engine; an engine without one lacks something.
    """
    asked = [entry for entry in entries if entry.spec]

    assert {entry.formulation for entry in asked} == set(FORMULATIONS)
    for engine in {entry.engine for entry in entries} - {entry.engine for entry in asked}:
        reasons = {entry.reason for entry in entries if entry.engine == engine}
        words = ("licen", "package", "linear solver", "initial guess")
        assert any(word in str(reason) for reason in reasons for word in words), engine
