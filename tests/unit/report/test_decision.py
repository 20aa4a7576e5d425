"""The table of choices: each choice turns when the rows that carry it change."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable
from typing import Any

import pandas as pd
import pytest
from typer.testing import CliRunner

from dubins_study.cli.app import app
from dubins_study.experiments.run import run
from dubins_study.report.data.command import run_command
from dubins_study.report.data.results import load
from dubins_study.report.elements.content import Place, Section
from dubins_study.report.page.environment import linked
from dubins_study.report.page.sections import TOPICS, sections_of
from dubins_study.report.statistics.methods import Compared, methods_of
from dubins_study.report.topics.decision import (
    ANYWHERE,
    Choice,
    choices,
    closed_form,
    decision_section,
)
from dubins_study.solvers.registry import load as load_solver
from dubins_study.solvers.registry import stated_method
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt, paper_scenarios
from tests.unit.report.results_folder import compared_row as row

MANY = 1000  # questions: with three wrong answers the interval still ends above 99 %
Row = dict[str, Any]


def rows(solver: str, wrong: int = 0, questions: int = MANY, **changes: Any) -> list[Row]:
    """Rows of one solver, the first `wrong` of them not right."""
    return [row(n, solver, right=n >= wrong, **changes) for n in range(questions)]


def table(*each: Iterable[Row]) -> dict[tuple[str, str], Choice]:
    """Region and need -> choice."""
    frame = pd.DataFrame([line for part in each for line in part])
    found = choices(Compared(frame, methods_of(frame), 2.0, ()))
    return {(choice.region, choice.need.key): choice for choice in found}


def test_a_need_that_the_settings_exclude_is_not_asked():
    """Equations that hold to 1e-8 prove no gap of 1e-8, only larger ones."""
    needs = {need for _, need in table(rows("a", lower_bound=4.0, tolerance=1e-8))}
    finer = {need for _, need in table(rows("a", lower_bound=4.0, tolerance=1e-9))}

    assert needs == {"loose", "tight", "loose_proof"}
    assert finer == needs | {"tight_proof"}


@pytest.mark.parametrize(
    ("spec", "asked"),
    [
        ("disjunctive", False),
        ("disjunctive[feastol=1e-9]", False),
        ("disjunctive[gap=1e-8]", False),
        ("disjunctive[gap=1e-8,feastol=1e-9]", True),
        ("global-nlp[gap=1e-8]", True),
    ],
)
def test_a_solver_says_what_its_settings_let_it_prove(spec, asked):
    """A proof of 1e-8 takes a gap of 1e-8, and a bound that is lowered by less."""
    method = stated_method(load_solver(spec))
    made = table(rows("a", lower_bound=4.0, tolerance=method.tolerance, proves=method.proves))

    assert (("far", "tight_proof") in made) is asked
    assert ("far", "loose_proof") in made


SLOW, FINE = rows("slow", wall_s=2e-3), rows("fine", wall_s=1.0)
GOOD, BAD = rows("good", wrong=40, wall_s=1.0), rows("bad", wrong=90, wall_s=1e-3)
LARGE = {"radius": 100.0, "length": 400.0, "reference": 400.0}
CLAIMS = rows("claims", claim="optimal")
PROOFS = [
    rows("coarser", claim="optimal", wall_s=1.0, lower_bound=4.0 - 1e-5),
    rows("finer", claim="optimal", wall_s=1.0, lower_bound=4.0 - 1e-9),
]
LIES = ({"false_bound": True}, {"claim": "optimal", "false_claim": True})
INSIDE = {"region": "left disc", "margin": 0.5}
TRUE_PROOFS = rows("liar", claim="optimal", lower_bound=4.0)


@pytest.mark.parametrize(
    ("each", "need", "expected"),
    [
        # of methods that are sure the fastest: up to three wrong answers of 1000 leave one sure,
        # with more the share is above 99 %, but not the lower end of its interval
        ([rows("fast", wrong=1), SLOW], "loose", {"solver": "fast", "share": 0.999}),
        ([rows("fast", wrong=1, wall_s=3e-3), SLOW], "loose", {"solver": "slow"}),
        ([rows("fast", wrong=3), SLOW], "loose", {"solver": "fast", "wall_s": 1e-3}),
        ([rows("fast", wrong=4), SLOW], "loose", {"solver": "slow"}),
        ([rows("fast", wrong=9), SLOW], "loose", {"solver": "slow"}),
        # of times that differ by less than a tenth the surer is taken
        ([rows("fast", wrong=1, wall_s=1.9e-3), SLOW], "loose", {"solver": "slow"}),
        # without a sure one the most surely right, however slow; of equals the fastest
        ([GOOD, BAD], "loose", {"solver": "good"}),
        ([GOOD, BAD, rows("twin", wrong=40, wall_s=0.5)], "loose", {"solver": "twin"}),
        # nothing is recommended where nothing is right, though methods were asked
        ([rows(s, wrong=MANY) for s in "ab"], "loose", {"solver": "", "methods": 2}),
        # a gap, a path that is too short, or an end beside the target: right, but not to 1e-8
        *(
            ([rows("coarse", **change), FINE], need, {"solver": solver})
            for change in ({"gap": 1e-7}, {"gap": -1e-7}, {"miss": 1e-7})
            for need, solver in (("loose", "coarse"), ("tight", "fine"))
        ),
        # the same miss is small for a large radius
        ([rows("x", miss=1e-7, **LARGE)], "tight", {"solver": "x", "share": 1}),
        ([rows("x", miss=1e-7)], "tight", {"solver": ""}),
        # a method that met few of the questions met others than its rivals
        (
            [rows("few", questions=MANY // 2, wall_s=1e-4), rows("all")],
            "loose",
            {"solver": "all", "methods": 1},
        ),
        # whoever needs a path does not ask for a word: the best branch counts if it was asked
        (
            [rows("x", wrong=MANY, branch="LS"), [row(MANY + n, "x") for n in range(20)]],
            "loose",
            {"share": 1},
        ),
        ([rows("x", wrong=MANY, branch="LS")], "loose", {"solver": ""}),
        # a claim without a bound proves nothing; a coarse bound proves a coarse gap only
        ([CLAIMS, *PROOFS], "loose_proof", {"solver": "coarser"}),
        ([CLAIMS, *PROOFS], "tight_proof", {"solver": "finer"}),
        ([CLAIMS], "loose_proof", {"solver": ""}),
        # who gave a false proof once is left out where a proof is needed, and not elsewhere
        *(
            ([[row(MANY, "liar", **lie, **INSIDE)], TRUE_PROOFS, *PROOFS], need, {"solver": solver})
            for lie in LIES
            for need, solver in (("loose", "liar"), ("loose_proof", "coarser"))
        ),
        ([TRUE_PROOFS, *PROOFS], "loose_proof", {"solver": "liar"}),
    ],
)
def test_the_choice_of_made_up_rows(each, need, expected):
    chosen = table(*each)["far", need]

    assert {name: getattr(chosen, name) for name in expected} == expected


def test_regions_follow_the_targets_place():
    """Near a circle wins over inside and outside; farther than five radii is far."""
    places = [("outside", 9.0), ("outside", 1.0), ("left disc", 0.5), ("right disc", 1e-3)]
    near = [row(n, "x", region=r, margin=m) for n, (r, m) in enumerate(places)]
    found = table(near)

    assert [region for region, need in found if need == "loose"] == [
        *(ANYWHERE, "far", "outside", "inside", "near")
    ]
    assert {found[region, "loose"].questions for region in ("far", "near")} == {1}
    assert found[ANYWHERE, "loose"].questions == 4


def test_each_region_has_a_choice_of_its_own():
    """A method that is fast everywhere and wrong next to circles is chosen elsewhere only."""
    near = {"region": "outside", "margin": 1e-4}
    fast = rows("fast") + [row(MANY + n, "fast", right=False, **near) for n in range(MANY)]
    sure = [row(n, "sure", wall_s=1.0, **(near if n >= MANY else {})) for n in range(2 * MANY)]
    found = table(fast, sure)

    assert found["far", "loose"].solver == "fast"
    assert found["near", "loose"].solver == "sure"
    assert found[ANYWHERE, "loose"].solver == "sure"


def test_the_closed_form_is_the_baseline_and_no_choice():
    frame = pd.DataFrame(rows("analytic", wall_s=1e-6) + rows("x"))
    compared = Compared(frame, methods_of(frame), 2.0, ())
    exact = closed_form(compared)

    assert exact is not None
    assert (exact.solver, exact.wall_s) == ("analytic", 1e-6)
    assert {choice.solver for choice in choices(compared)} == {"x", ""}
    alone = frame[frame["solver"] == "x"]
    assert closed_form(Compared(alone, methods_of(alone), 2.0, ())) is None


def _section(folders):
    results = load(folders)
    topic = next(topic for topic in TOPICS if topic.title == "what to use")
    return next(sections_of(topic, results))


def test_a_report_without_a_benchmark_answers_too_and_a_benchmark_alone(results):
    scenarios = paper_scenarios()
    bench = results("benchmark", [attempt(s, "slsqp") for s in scenarios])
    lines = [attempt(s, solver) for s in scenarios for solver in ("analytic", "ipopt")]
    for folder in (results(name, lines) for name in ("paper", "mine")):
        alone, together = _section([folder]), _section([folder, bench])
        assert alone.key == "decision"
        assert alone.blocks[0].frame["loose_solver"].eq("ipopt").all()
        assert "use the closed form (right on 100 %" in alone.lead
        assert together.blocks[0].frame["loose_solver"].eq("slsqp").all()


def test_a_report_without_anything_to_recommend_says_so(results):
    """Only failures, no closed form, only warm attempts: each in words."""
    scenarios = paper_scenarios()[:2]
    wrong = [attempt(s, "slsqp", path=astray(s), claim=Claim.FAILED) for s in scenarios]
    failures = _section([results("failures", wrong)])
    warm = _section([results("warm", [attempt(s, initial_guess="warm") for s in scenarios])])
    only = _section([results("only", [attempt(s) for s in scenarios])])

    assert "no other method was right on any question" in failures.lead
    assert "The closed form was not asked" in failures.text
    assert "Nothing can be recommended" in warm.lead
    assert warm.blocks == only.blocks == ()
    assert "no engine was asked" in only.lead


@pytest.mark.parametrize(
    ("command", "asked"),
    [
        ("dubins-study run paper --jobs 2", "paper"),
        ("dubins-study run my.toml --solver ipopt --time-limit 3", "my.toml --time-limit 3"),
        (
            "dubins-study run --scenarios 'my s.csv' --solver a --solver b --repeats 2",
            "--scenarios 'my s.csv' --repeats 2",
        ),
        (
            "dubins-study run --scenarios s.csv --solver 'nlp[a=1]' --jobs 4 --engine dask",
            "--scenarios s.csv",
        ),
        ("dubins-study run --scenarios 'no end", "'a b; rm c'"),
        ("", "'a b; rm c'"),
    ],
)
def test_the_command_asks_what_the_run_was_asked(results, command, asked):
    """The folder's own arguments, for a name alone names no file; other solvers answer.

    A name from outside is one word of the command.
    """
    named = {"name": "a b; rm c", "text": ""}
    folder = results("s", [attempt(paper_scenarios()[0])], command=command, experiment=named)
    manifest = load([folder]).folders[0].manifest

    assert run_command(manifest, "--solver X --out Y") == (
        f"dubins-study run {asked} --solver X --out Y"
    )


def test_the_command_on_the_page_of_a_file_of_scenarios_runs(tmp_path):
    """The page's line, with a solver and a folder filled in, asks the file's questions again."""
    file = tmp_path / "my s.csv"
    file.write_text("x,y,heading,target_x,target_y,radius\n0,0,0,4,1,1\n0,0,0,-2,3,1\n")
    folder = run(scenarios=file, solvers=["slsqp"], out=tmp_path / "first", time_limit=20)
    text = " ".join(decision_section(load([folder])).blocks[1].frame["command"])
    (line,) = re.findall("dubins-study (run .* --out MINE)", text)
    words = ["shooting" if word == "FILE.py:CLASS" else word for word in shlex.split(line)]
    done = CliRunner().invoke(app, [*words[:-1], str(tmp_path / "second")])

    assert done.exit_code == 0, done.output
    first, second = (load([tmp_path / name]).rows for name in ("first", "second"))
    assert set(second["solver"]) == {"shooting"}
    assert set(second["scenario_id"]) == set(first["scenario_id"])


def test_titles_of_sections_become_links():
    """To the section of that title, on its page; plain where there are several, a note where there
    is none."""
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
        "The paper's figures": '<a href="paper.html#paths">The paper&#39;s figures</a>',
        "The audit": "The audit (not on this page)",
    }.items():
        assert linked(title, sections, page) == link
