"""Colours and markers of solvers: by a rule, for a plug-in as for our own."""

from __future__ import annotations

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import INK
from dubins_study.study.scenario import Scenario
from tests.unit.report.results_folder import attempt

SPECS = ["slsqp", "analytic", "turn-rate-qp[n=50]", "turn-rate-qp", "ipopt", "my-plugin[a=1]"]


def test_a_solver_looks_the_same_in_every_figure():
    """Hue and marker are the page's; which other solvers a figure shows changes neither."""
    palette = Palette.of(SPECS)
    alone = palette.looks(["my-plugin[a=1]"])["my-plugin[a=1]"]
    together = palette.looks(SPECS)["my-plugin[a=1]"]

    assert (alone.colour, alone.marker) == (together.colour, together.marker)


def test_the_order_of_the_rows_changes_nothing():
    assert Palette.of(SPECS) == Palette.of(SPECS[::-1])


def test_solvers_differ_in_marker_and_variants_in_line():
    """What grey print keeps tells them apart; variants share their solver's hue."""
    looks = Palette.of(SPECS).looks(SPECS)
    plain, variant = looks["turn-rate-qp"], looks["turn-rate-qp[n=50]"]

    assert (plain.colour, plain.marker) == (variant.colour, variant.marker)
    assert plain.line != variant.line
    assert looks["analytic"].colour == INK
    assert len({look.marker for look in looks.values()}) == 5  # names


@pytest.mark.parametrize("count", [1, 9, 40])
def test_many_plug_ins_differ(count):
    """Hue and marker together repeat only where nobody could tell more apart."""
    specs = [f"solver-{i}" for i in range(count)]
    looks = Palette.of(specs).looks(specs)

    assert len({(look.colour, look.marker) for look in looks.values()}) == count


def test_a_page_draws_a_solver_as_its_engine(results):
    """Also by its name alone; another page with other solvers draws the engine alike."""
    scenario = Scenario(0, 0, 0, 4, 1)
    specs = {"nlp[engine=alpaqa]": "alpaqa", "collocation[n=9]": "Ipopt", "mine": "my engine"}
    rows = [attempt(scenario, spec, engine=engine) for spec, engine in specs.items()]
    palette = Palette.of_page(load([results("some", rows)]))
    other = Palette.of_page(load([results("other", rows[:1])]))
    looks = palette.looks(specs)

    for spec, engine in specs.items():
        assert (looks[spec].colour, looks[spec].marker) == palette.hues[engine]
        assert palette.hues[spec.partition("[")[0]] == palette.hues[engine]
    assert len({palette.hues[engine] for engine in specs.values()}) == len(specs)
    assert other.hues["alpaqa"] == palette.hues["alpaqa"]
