"""Solvers' words are text wherever they are shown.

The places are page, tables, terminal and JSON.
"""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dubins_study.report.page.render  # noqa: F401  its libraries write to places of their own when loaded
from dubins_study.study.scenario import Scenario
from tests.fuzz.hostile import HOSTILE, LONG_LIVED, MARK, texts
from tests.fuzz.page import check_json, check_report
from tests.fuzz.watched import command, raw_controls
from tests.unit.report.results_folder import attempt, write_folder
from tests.unit.report.topic_page import without_pdf_files

# what a row may hold: a text without halves of pairs
words = st.one_of(texts, st.text(st.characters(exclude_categories=["Cs"]), max_size=12))
_RUDE = """
from dubins_study.solvers.paper_nlp.nlp import Slsqp
from dubins_study.solvers.protocol import Claim, Solution

class Rude(Slsqp):
    name = summary = {text!r}
    method = ({text!r}, {text!r})

    def solve(self, model, limit):
        print({text!r})
        return Solution(Claim.FAILED, native_status={text!r}, message={text!r})
"""


@st.composite
def rows(draw):
    """Attempts with any texts from a plug-in.

    A few of them have a path.
    """
    attempts = []
    for number in range(draw(st.integers(1, 5))):
        texts_of_row = {
            name: draw(words) for name in ("message", "native_status", "word", "run_id")
        }
        scenario = Scenario(0, 0, 0, 5, number + 2, 1, label=draw(words))
        path = draw(st.sampled_from(["exact", None]))
        attempts.append(attempt(scenario, draw(words) or "s", path=path, **texts_of_row))
        if draw(st.booleans()):
            attempts[-1] |= {name: draw(words) for name in ("outcome", "claim", "verdict", "proof")}
    return attempts


@pytest.mark.slow
@settings(LONG_LIVED, max_examples=4)
@given(made=rows(), name=words)
def test_words_of_rows_are_shown_as_text(made, name, tmp_path_factory):
    folder = write_folder(tmp_path_factory.mktemp("words") / "run", name, made, cells=len(made))
    for request in (["status"], ["status", "--json"], ["report"]):
        with without_pdf_files():
            result = command(*request, str(folder))
        assert result.code == 0, result.err
        assert not raw_controls(result.out)
        if "--json" in request:
            check_json(result.out)
    check_report(folder / "report")


@pytest.mark.slow
def test_a_rude_plugin_is_quoted(tmp_path):
    """A rude plug-in is quoted.

    It is asked for real, once; its words come through escaped, and JSON stays JSON.
    """
    text = "".join(word for word in HOSTILE if MARK in word)
    plugin = tmp_path / "rude.py"
    plugin.write_text(_RUDE.format(text=text))
    spec = f"{plugin}:Rude"

    plain = command("solve", "3", "2", "--solver", spec)
    result = command("solve", "3", "2", "--solver", spec, "--json")

    assert "<script>" in plain.out
    assert not raw_controls(plain.out)
    assert json.loads(result.out)["message"] == text
    experiment = tmp_path / "rude.toml"
    experiment.write_text(
        'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n'
        "[[scenarios]]\ntarget_x = 3\ntarget_y = 2\n"
    )
    out = tmp_path / "out"
    ran = command("run", str(experiment), "--solver", spec, "--out", str(out))
    assert ran.code == 0, ran.err
    assert not raw_controls(ran.out)
    assert command("report", str(out)).code == 0
    check_report(out / "report")
