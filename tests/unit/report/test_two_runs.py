"""Two runs compared.

The rows are made up, with known changes; SciPy's tests stand beside ours.
"""

import json
import shlex
from dataclasses import replace

import pytest
from scipy import stats
from typer.testing import CliRunner

from dubins_study import Claim, DubinsStudyError, Scenario, compare
from dubins_study.cli.app import app
from tests.unit.report.results_folder import attempt

SCENARIOS = [Scenario(0, 0, 0.1, 4 + k, 3 - k, 1, label=f"scenario {k}") for k in range(12)]
# The target lies in the left disc: no path LS.
DISC = Scenario(0, 0, 0, 0.5, 1, 1, label="disc")
OLD, NEW = "111111111111", "222222222222"


def rows(solver="mine", digest=OLD, time=1e-3, wrong=(), scenarios=SCENARIOS, **changes):
    """One attempt a scenario.

    At the scenarios of `wrong` no path comes back.
    """
    return [
        attempt(
            scenario,
            solver,
            scenario_id=f"{place:08x}",
            code_digest=digest,
            wall_s=time * (1 + place / 100),
            **({"path": None, "claim": Claim.FAILED} if place in wrong else {}),
            **changes,
        )
        for place, scenario in enumerate(scenarios)
    ]


def of(comparison, solver="mine"):
    return comparison.solvers.set_index("solver").loc[solver]


def test_a_run_compared_with_itself_has_no_change(results):
    entry = {"settings": {}, "code_digest": OLD, "cells": 13}
    untaken = attempt(SCENARIOS[0], "mine", path=None, outcome="unsupported", scenario_id="x")
    folder = results("a", [*rows(), untaken | {"code_digest": OLD}], solvers={"mine": entry})
    comparison = compare(folder, folder)
    line = of(comparison)

    assert not comparison.regressed
    assert comparison.unpaired.empty
    assert comparison.differences.empty
    assert (line["right_base"], line["right_new"], line["lost"], line["gained"]) == (1, 1, 0, 0)
    assert line["time_ratio"] == pytest.approx(1, rel=1e-12)  # a mean of logarithms of 1


def test_lost_answers_are_named_with_their_scenarios_and_commands(results):
    """Lost answers have scenarios and commands.

    Each question that is no longer right has a line; the paired test is McNemar's exact one.
    """
    base = results("a", rows(wrong=(0,)))
    new = results("b", rows(digest=NEW, wrong=(3, 5, 7, 8, 9, 10)))
    comparison = compare(base, new)
    line = of(comparison)
    worse = comparison.regressions

    assert (line["lost"], line["gained"], line["questions"]) == (6, 1, 12)
    assert (line["right_base"], line["right_new"]) == (11 / 12, 6 / 12)
    assert line["right_p"] == pytest.approx(stats.binomtest(1, 7).pvalue, rel=1e-12)
    assert worse["kind"].tolist() == ["no longer right"] * 6
    assert worse["scenario"][0] == "scenario 3: target 7, 0"
    assert shlex.split(worse["command"][0]) == [
        *("dubins-study", "solve", "--from", "0", "0", "0.1", "--solver", "mine"),
        *("--", "7", "0"),
    ]


def test_the_machine_is_taken_out_by_solvers_of_the_same_code(results):
    """Solvers of the same code cancel the machine.

    A control that took 1.5 times as long divides the times of the solver that changed.
    """
    base = results("a", rows(time=1e-3) + rows("still", time=2e-3))
    new = results("b", rows(digest=NEW, time=3e-3) + rows("still", time=3e-3))
    comparison = compare(base, new)
    line = of(comparison)
    still = of(comparison, "still")

    assert comparison.speed.ratio == pytest.approx(1.5, rel=1e-12)
    assert line["time_ratio"] == pytest.approx(3 / 1.5, rel=1e-12)
    assert comparison.regressions["kind"].tolist() == ["slower"]
    assert still["same_code"]
    assert still["time_ratio"] == pytest.approx(1.5, rel=1e-12)  # the machine's doing
    few = [row for row in rows(digest=NEW, time=3e-3) if row["scenario_id"] < "00000005"]
    assert not compare(base, results("e", few + rows("still", time=3e-3))).regressed
    slow = results("c", rows(digest=NEW, time=3e-3) + rows("still", time=6e-3))
    assert not compare(base, slow).regressed  # all took three times as long


def test_no_solver_is_slower_where_every_solver_changed(results):
    """No solver is slower if all have changed.

    Then nothing says what the machine did.
    """
    without = compare(results("c", rows(time=1e-3)), results("d", rows(digest=NEW, time=9e-3)))

    assert without.speed is None
    assert of(without)["time_ratio"] == pytest.approx(9, rel=1e-12)
    assert not without.regressed


def test_false_claims_denials_and_accuracy_are_kinds_of_their_own(results):
    """Claims, denials and accuracy are separate kinds.

    There are a new false claim, a denial that is gone, and a gap that grew tenfold.
    """
    near = SCENARIOS[0]
    exact = attempt(near, "mine", scenario_id="1", gap=1e-6, code_digest=OLD)
    coarse = exact | {"gap": 3e-5, "code_digest": NEW}
    denied = attempt(DISC, "mine", "LS", None, Claim.INFEASIBLE, scenario_id="2", code_digest=OLD)
    silent = attempt(DISC, "mine", "LS", None, Claim.FAILED, scenario_id="2", code_digest=NEW)
    honest = attempt(SCENARIOS[1], "mine", path=None, claim=Claim.FAILED, scenario_id="3")
    lying = attempt(SCENARIOS[1], "mine", path=None, claim=Claim.INFEASIBLE, scenario_id="3")
    base = results("a", [exact, denied, honest | {"code_digest": OLD}])
    new = results("b", [coarse, silent, lying | {"code_digest": NEW}])
    comparison = compare(base, new)

    assert set(comparison.regressions["kind"]) == {
        *("false claim", "no longer denied", "less accurate")
    }
    assert of(comparison)["questions"] == 2  # the third has no path
    # 1e-12 and 1e-7 are both below a miss that still arrives
    fine, finer = results("c", [exact | {"gap": 1e-7}]), results("d", [exact | {"gap": 1e-12}])
    assert not compare(finer, fine).regressed


def test_repeats_are_one_question(results):
    """Repeats are one question.

    A question that is right in half of its repeats is neither lost nor gained.
    """
    first, second = (
        [row | {"repeat": repeat} for row in rows(digest=digest, wrong=wrong)]
        for repeat, digest, wrong in ((0, NEW, (1,)), (1, NEW, ()))
    )
    comparison = compare(results("a", rows()), results("b", first + second))

    assert (of(comparison)["questions"], of(comparison)["lost"]) == (12, 0)
    assert of(comparison)["right_new"] == pytest.approx(23 / 24, rel=1e-12)


def test_a_solver_that_is_right_in_fewer_repeats_is_worse(results):
    """Fewer right repeats make a solver worse.

    No question is lost altogether, yet each is right in one of three repeats: 12 of 12 fell.
    """
    every, fewer = [], rows(digest=NEW, repeat=0)
    for repeat in range(3):
        every += rows(repeat=repeat)
        fewer += rows(digest=NEW, repeat=repeat, wrong=range(12)) if repeat else []
    base, new = results("a", every), results("b", fewer)
    there, back = compare(base, new), compare(new, base)

    assert of(there)["lost"] == 0
    assert of(there)["right_p"] == pytest.approx(stats.binomtest(0, 12).pvalue, rel=1e-12)
    assert there.regressions["kind"].tolist() == ["right less often"]
    assert there.regressions["new"][0] == "right in 33.3 %"
    assert there.solvers["verdict"].tolist() == ["worse: right less often"]
    assert not back.regressed
    assert back.solvers["verdict"].tolist() == ["better: right more often"]


def test_what_only_one_run_was_asked_is_counted_apart(results):
    """Questions of one run alone are counted apart.

    A solver that is missing and questions that are missing are in a table of their own.
    """
    base = results("a", rows() + rows("gone"))
    new = results("b", rows(digest=NEW, scenarios=SCENARIOS[:9]), versions={"numpy": "9"})
    comparison = compare(base, new)
    counts = comparison.unpaired.set_index("solver")

    assert counts.loc["gone"].tolist() == [12, 0]
    assert counts.loc["mine"].tolist() == [3, 0]
    changed = comparison.differences.set_index("what")
    assert changed.loc["version of numpy", ["base", "new"]].tolist() == ["2.3", "9"]
    assert not of(comparison)["same_code"]


@pytest.mark.slow
def test_a_run_that_lacks_what_it_was_asked_has_become_worse(results):
    """A run without asked cells has become worse.

    Cells without a row fail a comparison; questions that were never asked do not.
    """
    entry = {"settings": {}, "code_digest": NEW, "cells": 12}
    base = results("a", rows())
    part = results("b", rows(digest=NEW, scenarios=SCENARIOS[:9]), solvers={"mine": entry})
    small = results("c", rows(digest=NEW, scenarios=SCENARIOS[:9]))
    (line,) = compare(base, part).regressions.to_dict("records")

    assert (line["kind"], line["solver"]) == ("not answered", "mine")
    assert line["new"] == "9 of the 12 cells asked"
    assert not compare(base, small).regressed
    shown = CliRunner().invoke(app, ["compare", str(base), str(small), "--fail-on-regression"])
    assert shown.exit_code == 0
    assert "Not compared: only the base run was asked 3 questions of 1 solver." in shown.stdout


def test_runs_without_a_common_question_are_refused(results):
    base, new = results("a", rows("one")), results("b", rows("other"))

    with pytest.raises(DubinsStudyError, match="share no question"):
        compare(base, new)
    with pytest.raises(DubinsStudyError, match="at least 1"):
        compare(base, base, slower=0.9)


@pytest.mark.slow
def test_the_command_its_exit_codes_and_its_page(results, tmp_path):
    """The command has exit codes and a page.

    They are 0; 1 with --fail-on-regression if something is worse; 2 for a bad request. Names are
    hostile.
    """
    name = "<script>alert(1)</script>&[x=1]"
    scenarios = [replace(s, label="<b>$HOME`x`\u202e") for s in SCENARIOS]
    base = results("a", rows(name, scenarios=scenarios))
    new = results("b", rows(name, digest=NEW, wrong=(0, 1), scenarios=scenarios))
    runner = CliRunner()
    page = tmp_path / "page"
    asked = [str(base), str(new)]
    plain = runner.invoke(app, ["compare", *asked, "--out", str(page)])
    strict = runner.invoke(app, ["compare", *asked, "--fail-on-regression", "--json"])
    same = runner.invoke(app, ["compare", str(base), str(base), "--fail-on-regression"])

    assert (plain.exit_code, strict.exit_code, same.exit_code) == (0, 1, 0)
    record = json.loads(strict.stdout)
    assert record["regressed"]
    assert len(record["regressions"]) == 2
    assert record["solvers"][0]["solver"] == name
    assert "\u202e" not in plain.stdout
    text = (page / "index.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert" in text
    bad = runner.invoke(app, ["compare", str(base), str(tmp_path / "nothing")])
    assert isinstance(bad.exception, DubinsStudyError)  # `main` prints it and leaves with 2
