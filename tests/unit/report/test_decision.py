"""Where engines err, and a plug-in among them.

A plug-in's solver has its name, its place and its look.
"""

import pandas as pd
import pytest
from scipy.stats import binomtest

from dubins_study import render
from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE, own_name
from dubins_study.report.data.results import load
from dubins_study.report.elements.content import Place, Section
from dubins_study.report.elements.looks import Palette, labels_of
from dubins_study.report.elements.style import ENGINE_HUES, VERMILION
from dubins_study.report.page.environment import linked
from dubins_study.report.page.sections import TOPICS, sections_of
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.belief import belief_section
from dubins_study.report.topics.decision import best_supported, decision_section, ends, stops
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt, compared_row, paper_scenarios

WORDS = ("one NLP a word", "words")


def row(question, solver, **changes):
    columns = {"experiment": "leg", "guesses": "words", "outcome": "returned"} | changes
    return compared_row(question, solver, **columns)


def test_the_surest_is_the_one_with_the_highest_lower_end():
    """The surest has the highest lower end.

    All of 4 are less sure than 39 of 40; of two the faster is taken; a sample displaces no whole.
    """
    rows = [row(q, "few") for q in range(4)]
    rows += [row(q, "many", right=q > 0) for q in range(40)]
    rows += [row(q, "slow", right=q > 0, wall_s=9.0) for q in range(40)]
    rows += [row(q, "sample", experiment="pose") for q in range(19)]
    rows += [row(q, "whole", experiment="pose", right=q > 9) for q in range(40)]
    best = best_supported(pd.DataFrame(rows))

    assert best.loc[("leg", *WORDS), "solver"] == "many"
    assert best.loc[("pose", *WORDS), "solver"] == "whole"
    low = binomtest(39, 40).proportion_ci(method="wilson").low
    assert best.loc[("leg", *WORDS), "low"] == pytest.approx(low)


def test_every_attempt_ends_in_one_way():
    """Every attempt ends in one way.

    Two engines have one formulation; a right answer that came late is late, not right.

    Attempts that were not made can make no false claim.
    """
    kinds = [
        *({"verdict": "longer", "right": False}, {"verdict": "misses", "right": False}),
        *({"verdict": "none", "right": False}, {"right": False, "late": True}, {}),
    ]
    rows = [row(q, "ab"[q % 2], **kinds[q % 5]) for q in range(20)]
    rows[0]["false_claim"] = True
    rows[2]["outcome"] = "not_asked"
    end = ends(pd.DataFrame(rows))[WORDS]

    shares = {"longer": 0.2, "misses": 0.2, "late": 0.2, "none": 0.15, "not asked": 0.05}
    assert end == shares | {"false_claims": 1, "asked": 19}


def test_an_engine_stops_where_it_is_right_on_half_or_fewer():
    """An engine stops at half right or fewer.

    The engine that goes furthest counts; a spacing at which none begins is 0, and one that was not
    asked has a dash.
    """
    rows = []
    for label, most in (("long", 5), ("short", 0)):
        for legs in (1, 2, 5, 10):
            for q in range(4):
                via = [1.0] * (legs - 1) or None
                right = legs <= most or (legs == 10 and q < 2)
                rows.append(row(q, "a", label=label, via_x=via, right=right))
                rows.append(row(q, "b", label=label, via_x=via, right=False))
    rows += [one | {"guesses": "one"} for one in rows if one["label"] == "long"]
    plain = pd.DataFrame([row(q, "a", label="leg") for q in range(4)])

    limits = stops(pd.DataFrame(rows), ["short", "long"])
    assert limits == {WORDS: "0, 5", (WORDS[0], "one"): "–, 5"}
    assert stops(plain, ["leg"]) == {}


def _section(folders):
    results = load(folders)
    topic = next(topic for topic in TOPICS if topic.title == "where engines err")
    return next(sections_of(topic, results))


def _asked(section):
    """The solvers that the table's first suite names."""
    return {text.partition("\n")[0] for text in section.blocks[0].frame["suite_0"]}


def test_a_report_without_a_benchmark_answers_too_and_a_benchmark_alone(results):
    """A report answers with a benchmark or without.

    With a benchmark on the page the table is of its rows; its lines name what can be typed.
    """
    scenarios = paper_scenarios()
    bench = results("benchmark", [attempt(s, "slsqp") for s in scenarios])
    ours = {"formulation": "one NLP a word", "engine": "Ipopt"}
    exact = {"formulation": "closed form", "engine": "analytic"}
    lines = [attempt(s, **exact) for s in scenarios] + [
        attempt(s, "ipopt", **ours) for s in scenarios
    ]
    for folder in (results(name, lines) for name in ("paper", "mine")):
        alone, together = _section([folder]), _section([folder, bench])
        assert alone.key == "decision"
        assert _asked(alone) == {"analytic", "ipopt"}
        assert "right in time on 7 of 7 questions" in alone.lead
        assert _asked(together) == {"slsqp"}


def test_a_report_without_anything_to_compare_says_so(results):
    """Reports without a comparison say so.

    They have only warm attempts, or one solver.
    """
    scenarios = paper_scenarios()[:2]
    warm = _section([results("warm", [attempt(s, initial_guess="warm") for s in scenarios])])
    only = _section([results("only", [attempt(s) for s in scenarios])])

    assert "Nothing can be compared" in warm.lead
    assert warm.blocks == ()
    assert "right in time on 2 of 2 questions" in only.lead


def test_titles_of_sections_become_links():
    """Titles of sections become links.

    The link is to the section of that title, on its page. The title is plain where there are
    several, and a note where there is none.
    """
    page = "index.html"
    sections = [
        Section("paths", "The paper's figures", "", (), place=Place.PAPER),
        Section("matrix", "Formulation by engine", "", ()),
        Section("cost-a", "Cost where it arises: a", "", ()),
        Section("cost-b", "Cost where it arises: b", "", ()),
    ]

    for title, link in {
        "Formulation by engine: <strata>": (
            '<a href="#matrix">Formulation by engine: &lt;strata&gt;</a>'
        ),
        "Cost where it arises: the presolve": "Cost where it arises: the presolve",
        "Cost where it arises: b": '<a href="#cost-b">Cost where it arises: b</a>',
        "The paper's figures": '<a href="paper.html#paths">The paper&#39;s figures</a>',
        "The audit": "The audit (not on this page)",
    }.items():
        assert linked(title, sections, page) == link


MINE = "my_solver.py:MySolver"
VARIANT = "my_solver.py:MySolver[guesses=8]"


def rows(questions: int, *specs: str) -> list[dict[str, object]]:
    """Three engines and a file's solvers.

    The file's are wrong at every other question.
    """
    attempts = []
    for number in range(questions):
        scenario = Scenario(target_x=4 + number, target_y=2)
        lost = {"path": astray(scenario)} if number % 2 else {}
        attempts += [
            attempt(scenario, formulation="closed form", engine="closed form", guess="none")
        ]
        for name, engine in (("ipopt", "Ipopt"), ("slsqp", "SLSQP")):
            attempts.append(attempt(scenario, name, claim=Claim.LOCAL, engine=engine))
        method = {"engine": "SciPy least_squares", "formulation": WORDS[0], "claim": Claim.LOCAL}
        attempts += [attempt(scenario, spec, **method, **lost) for spec in specs]
    return attempts


def test_it_is_named_by_its_own_name(load_rows):
    results = load_rows("mine", rows(3, MINE, VARIANT))
    labels = labels_of(results)

    assert (labels[MINE], labels[VARIANT]) == ("MySolver", "MySolver, guesses=8")
    assert own_name("ipopt[presolve=True]") == ""
    assert labels["ipopt"] == "Ipopt, word NLPs"


def test_it_stands_first(load_rows):
    """It stands first in tables.

    They are tables of methods, and of solvers.
    """
    results = load_rows("mine", rows(ENOUGH_TO_CHOOSE, MINE))
    (decided, *_) = decision_section(results).blocks

    assert solver_summary(results.attempts)["solver"].iloc[0] == MINE
    assert solver_order(["analytic", "ipopt", MINE])[0] == MINE
    assert decided.frame["method"].iloc[0] == "MySolver"


def test_it_has_a_line_with_a_limit_of_its_own(load_rows):
    """A reader's own solver may have more time than the others.

    An engine's attempts with more time than others had are not compared.
    """
    longer = [
        attempt | {"limit_s": 60.0 if attempt["solver"] in (MINE, "ipopt") else 1.0}
        for attempt in rows(ENOUGH_TO_CHOOSE, MINE)
    ]
    table = decision_section(load_rows("mine", longer, section="benchmark")).blocks[0].frame

    assert "MySolver" in set(table["method"])
    assert "ipopt" not in table.to_string()


def test_it_is_drawn_where_few_of_many_are(load_rows):
    """It is drawn where few of many are.

    It has a hue that no engine has, however many methods are better; a second one has another.
    """
    other = "my_solver.py:Other"
    looks = Palette.of_page(load_rows("mine", rows(2, MINE, other))).looks([MINE, other, "ipopt"])

    assert (looks[MINE].colour, looks[MINE].marker) == (VERMILION, "*")
    assert VERMILION not in {hue.light for hue in ENGINE_HUES}
    assert len({look.colour for look in looks.values()}) == 3


def test_it_takes_no_place_of_others_claims(load_rows, monkeypatch):
    """It takes no place of others' claims.

    Among the bars of claims the engines are those that stand there without it.
    """
    monkeypatch.setattr("dubins_study.report.topics.belief._MOST_BARS", 1)
    bars = {}
    for specs in ((), (MINE,)):
        figure = belief_section(load_rows(str(specs), rows(4, *specs))).blocks[0].figure
        bars[specs] = {text.get_text() for ax in figure.axes for text in ax.get_yticklabels()}

    assert bars[MINE,] == bars[()] | {"MySolver"}


def test_few_questions_choose_no_winner(load_rows, monkeypatch):
    """Few questions choose no winner.

    Then every method has a line; with enough questions it is the best-supported engine of its
    kind.

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
    assert "every method has a line" in every.caption
    assert not every.frame["suite_0"].str.contains("\n").iloc[0]
    assert sorted(beside.frame["method"]) == sorted(lines)
    assert beside.marks == {(0, "false"): "bad"}
    assert chosen.frame["method"].tolist() == ["MySolver", "closed form", WORDS[0]]
    assert [text.partition("\n")[0] for text in chosen.frame["suite_0"][1:]] == [
        "analytic",
        "ipopt",
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("title", "heading"), [("My trial", "My trial"), ("", "trial")])
def test_the_heading_is_the_experiments(results, tmp_path, title, heading):
    """The heading is the experiment's.

    It has title and question of one experiment; of several it is the report's.
    """
    definition = {"name": "trial", "title": title, "question": "Is it mine?", "text": "a = 1"}
    mine = results("trial", rows(1, MINE), experiment=definition)
    page = render([mine], tmp_path / "one").read_text(encoding="utf-8")
    both = render([mine, results("other", rows(1, MINE))], tmp_path / "two")

    assert f"<h1>{heading}</h1>" in page
    assert '<p class="asked">Is it mine?' in page
    assert "<h1>The shortest path of a vehicle that cannot turn tightly</h1>" in both.read_text(
        encoding="utf-8"
    )


def test_an_unfinished_run_has_its_table(load_rows):
    """No solver has met enough questions, though all together have."""
    solvers = ("ipopt", "slsqp", "shooting")
    scenarios = [Scenario(target_x=4 + n, target_y=2) for n in range(ENOUGH_TO_CHOOSE)]
    attempts = [attempt(s, solvers[n % 3], claim=Claim.LOCAL) for n, s in enumerate(scenarios)]
    section = decision_section(load_rows("half", attempts, section="benchmark"))

    assert len(section.blocks[0].frame) == 3
