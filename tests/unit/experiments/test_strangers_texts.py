"""Experiments written to do harm: each is refused before it costs anything."""

from __future__ import annotations

import pytest

from dubins_study.experiments.definition.experiment import ExperimentError, parse, read
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.plan.solver_description import (
    MOST_SPECS,
    expand_solvers,
    untrusted_spec,
)
from dubins_study.solvers.registry import SolverError

HEAD = 'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n'
BLOCK = "[[scenarios]]\ntarget_x = 3\ntarget_y = 2\n"


@pytest.mark.parametrize("ask", [expand_solvers, untrusted_spec])
def test_braces_do_not_multiply_without_end(ask):
    """Forty pairs would be a million million specs."""
    with pytest.raises(SolverError, match=f"more than {MOST_SPECS} specs"):
        ask(["{analytic,}" + "{,}" * 40])


@pytest.mark.parametrize("ask", [expand_solvers, untrusted_spec])
def test_a_spec_has_an_end(ask):
    """Thousands of braces in one another are deeper than Python goes."""
    with pytest.raises(SolverError, match="has 6000 characters; expected at most 500"):
        ask(["{" * 3000 + "}" * 3000])


def test_what_nobody_is_asked_is_not_expanded():
    """The closed form takes no warm start, so a thousand million repeats of that are no cells."""
    text = HEAD + 'initial_guesses = ["warm"]\nrepeats = 1000000000\n' + BLOCK

    assert chains(parse("name", "name.toml", text).experiment) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + '"a\\nb\\u001b" = 1\n' + BLOCK, "'a\\nb\\x1b': unknown key"),
        (HEAD + f'"{"k" * 9000}" = 1\n' + BLOCK, f"'{'k' * 80}': unknown key"),
        (HEAD + f"seed = 0x{'f' * 9000}\n" + BLOCK, "seed holds an integer of thousands"),
        (HEAD + f"repeats = 0x{'f' * 9000}\n" + BLOCK, "repeats holds an integer of"),
        (HEAD + f"branches = ['{'[' * 9000}']\n" + BLOCK, "branches is ['[[["),
    ],
)
def test_what_is_quoted_is_one_short_line(text, message):
    with pytest.raises(ExperimentError) as error:
        parse("f", "f.toml", text)

    assert str(error.value).startswith(f"f.toml: line 4: {message}")
    assert str(error.value).isprintable()
    assert len(str(error.value)) < 600


@pytest.mark.parametrize("name", ["..toml", "...toml"])
def test_a_name_that_leads_out_of_the_results_is_none(name, tmp_path, monkeypatch):
    """`results/..` is where somebody works."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(HEAD + BLOCK)

    with pytest.raises(ExperimentError, match="no experiment named"):
        read(name)
