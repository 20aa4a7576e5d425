"""Experiments from strangers: expanded, or refused in one line; never a traceback, never code."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings

from dubins_study.experiments.definition.experiment import ExperimentError, packaged, parse
from dubins_study.experiments.plan import cells as cells_module
from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.solvers.registry import SolverError
from tests.fuzz.hostile import LONG_LIVED, MARK
from tests.fuzz.toml_text import experiments, mutilated, text_of
from tests.fuzz.watched import raw_controls, watched

FOLDER = Path(__file__).parents[2] / "src" / "dubins_study" / "experiments"
PACKAGED = [(FOLDER / f"{name}.toml").read_bytes() for name in packaged()]
pytestmark = pytest.mark.usefixtures("little_room")
# characters of a line that quotes what it is about, and lines
LONGEST, MOST_LINES = 1000, 21


def check_lines(message: str) -> None:
    """One line, or a head and an indented line a mistake, none of them without end."""
    head, *mistakes = message.split("\n")
    assert len(head) < LONGEST
    assert all(line.startswith("  ") and len(line) < LONGEST for line in mistakes)
    assert len(mistakes) != 1
    assert len(mistakes) <= MOST_LINES


@settings(LONG_LIVED)
@given(fields=experiments())
def test_an_experiment_is_expanded_or_refused(fields, tmp_path_factory, song):
    """As `dubins-study run FILE` does, up to the point where cells are solved."""
    place = tmp_path_factory.getbasetemp()
    file = place / f"{MARK}.toml"
    file.write_text(text_of(fields))
    request = Request(str(file))
    with watched() as seen:
        try:
            chains = plan_run(request).chains
        except (ExperimentError, SolverError) as error:
            message = str(error)
            assert file.name in message
            assert not raw_controls(message)
            check_lines(message)
        else:
            assert sum(map(len, chains)) <= cells_module.MOST_CELLS
    assert not song.exists()
    assert not [*seen.started, *seen.unpickled, *seen.outside(place)]


@settings(LONG_LIVED)
@given(content=mutilated(PACKAGED))
def test_a_mutilated_file_is_parsed_or_refused(content):
    text = content.decode("utf-8", "replace")
    try:
        parse("name", f"{MARK}.toml", text)
    except ExperimentError as refusal:
        message = str(refusal)
    else:
        return
    assert message.startswith(f"{MARK}.toml: ")
    assert not raw_controls(message)
    check_lines(message)
