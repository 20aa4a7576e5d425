"""A plug-in's solver: its name, its place, its look; and few questions choose no winner."""

from __future__ import annotations

import pytest

from dubins_study import render
from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, own_name
from dubins_study.report.elements.looks import Palette, labels_of
from dubins_study.report.elements.style import ENGINE_HUES, VERMILION
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.belief import belief_section
from dubins_study.report.topics.comparison import comparison_section
from dubins_study.report.topics.decision import decision_section
from dubins_study.report.topics.summary import best_solvers, solver_summary
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt

MINE, VARIANT = "my_solver.py:MySolver", "my_solver.py:MySolver[guesses=8]"
WORDS = "one NLP a word"


def rows(questions: int, *specs: str) -> list[dict[str, object]]:
    """Three engines and some solvers of a file; the file's are wrong at every other question."""
    made = []
    for number in range(questions):
        scenario = Scenario(target_x=4 + number, target_y=2)
        lost = {"path": astray(scenario)} if number % 2 else {}
        made += [attempt(scenario, formulation="closed form", engine="closed form", guess="none")]
        for name, engine in (("ipopt", "Ipopt"), ("slsqp", "SLSQP")):
            made.append(attempt(scenario, name, claim=Claim.LOCAL, engine=engine))
        method = {"engine": "SciPy least_squares", "formulation": WORDS, "claim": Claim.LOCAL}
        made += [attempt(scenario, spec, **method, **lost) for spec in specs]
    return made


def test_it_is_named_by_its_own_name(load_rows):
    results = load_rows("mine", rows(3, MINE, VARIANT))
    labels = labels_of(results)

    assert (labels[MINE], labels[VARIANT]) == ("MySolver", "MySolver, guesses=8")
    assert own_name("ipopt[presolve=True]") == ""
    assert labels["ipopt"] == "Ipopt, word NLPs"


def test_it_stands_first(load_rows):
    """In tables of methods, of solvers, and in the short form of long tables."""
    results = load_rows("mine", rows(ENOUGH_TO_CHOOSE, MINE))
    (decided, *_) = decision_section(results).blocks

    assert solver_summary(results.attempts)["solver"].iloc[0] == MINE
    assert solver_order(["analytic", "ipopt", MINE])[0] == MINE
    assert best_solvers(results)[0] == MINE
    assert decided.frame["method"].iloc[0] == "MySolver"


def test_it_is_drawn_where_few_of_many_are(load_rows):
    """With a hue that no engine has, however many methods are better; a second one has another."""
    other = "my_solver.py:Other"
    looks = Palette.of_page(load_rows("mine", rows(2, MINE, other))).looks([MINE, other, "ipopt"])

    assert (looks[MINE].colour, looks[MINE].marker) == (VERMILION, "*")
    assert VERMILION not in {hue.light for hue in ENGINE_HUES}
    assert len({look.colour for look in looks.values()}) == 3


def test_it_takes_no_place_of_others_claims(load_rows, monkeypatch):
    """Among the bars of claims the engines are those that stand there without it."""
    monkeypatch.setattr("dubins_study.report.topics.belief._MOST_BARS", 1)
    bars = {}
    for specs in ((), (MINE,)):
        figure = belief_section(load_rows(str(specs), rows(4, *specs))).blocks[0].figure
        bars[specs] = {text.get_text() for ax in figure.axes for text in ax.get_yticklabels()}

    assert bars[MINE,] == bars[()] | {"MySolver"}


def test_few_questions_choose_no_winner(load_rows, monkeypatch):
    """Then every method has a line; of enough questions the surest engine has that of its kind.

    Unless a reader's own solver is there, and few others: they are what it was put beside.
    """
    few, enough = (
        load_rows(str(number), rows(number, MINE), section="benchmark")
        for number in (ENOUGH_TO_CHOOSE - 1, ENOUGH_TO_CHOOSE)
    )
    every, beside = (decision_section(each).blocks[0] for each in (few, enough))
    monkeypatch.setattr("dubins_study.report.topics.decision._MOST_LINES", 3)
    chosen = decision_section(enough).blocks[0]
    lines = ["MySolver", "closed form", "Ipopt, word NLPs", "SLSQP, word NLPs"]

    assert sorted(every.frame["method"]) == sorted(lines)
    assert "choose no engine" in every.caption
    assert not every.frame["suite_0"].str.contains("\n").iloc[0]
    assert sorted(beside.frame["method"]) == sorted(lines)
    assert beside.marks == {(0, "false_claims"): "bad"}
    assert chosen.frame["method"].tolist() == ["MySolver", "closed form", WORDS]
    assert [text.partition("\n")[0] for text in chosen.frame["suite_0"][1:]] == [
        "analytic",
        "ipopt",
    ]
    assert "The least mean time" not in comparison_section(few).text
    assert "over 30 questions has" in comparison_section(enough).text


@pytest.mark.parametrize(("title", "heading"), [("My trial", "My trial"), ("", "trial")])
def test_the_heading_is_the_experiments(results, tmp_path, title, heading):
    """Title and question of one experiment; of several the report's."""
    definition = {"name": "trial", "title": title, "question": "Is it mine?", "text": "a = 1"}
    mine = results("trial", rows(1, MINE), experiment=definition)
    page = render([mine], tmp_path / "one").read_text(encoding="utf-8")
    both = render([mine, results("other", rows(1, MINE))], tmp_path / "two")

    assert f"<h1>{heading}</h1>" in page
    assert '<p class="asked">Is it mine?</p>' in page
    assert "<h1>The shortest bounded-curvature path</h1>" in both.read_text(encoding="utf-8")
