"""`export SUITE` and `judge`, from suite to verdicts.

The verdicts are on a file of answers.
"""

import pytest

from dubins_study.cli.terminal.arguments import CommandError
from tests.unit.cli.conftest import asked

SUITE = """
title = "T"
question = "Q?"
solvers = ["analytic"]
[[scenarios]]
target_x = [3, 6]
target_y = 2
"""


@pytest.fixture
def exported(tmp_path, monkeypatch):
    """A folder with a suite and its files."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.toml").write_text(SUITE)
    done = asked("export", "two.toml", "--formulation", "paper", "--out", "set")
    assert done.stdout == "2 instances, 4 files; the table is set/instances.csv\n"
    return tmp_path


def test_the_best_known_paths_are_answers(exported):
    """The best-known paths are answers.

    The other columns of the table are passed over; nothing is wrong, so that the end is 0.
    """
    done = asked("judge", "set/instances.csv", "--suite", "two.toml", "--out", "judged")

    assert done.exit_code == 0
    assert "2 optimal" in done.stdout
    assert "dubins-study report judged" in done.stdout


def test_a_false_claim_ends_with_1_and_is_named(exported):
    id_ = (exported / "set" / "instances.csv").read_text().splitlines()[1].partition(",")[0]
    (exported / "a.csv").write_text(f"id,curvatures,lengths,claim\n{id_},0,1,optimal\n")

    done = asked("judge", "a.csv", "--suite", "two.toml")

    assert done.exit_code == 1
    assert f"false claim of a: {id_}, verdict misses" in done.stdout
    assert (exported / "results" / "a" / "manifest.json").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["10"], "export of '10', which is no target X Y, needs --formulation SPEC"),
        (["two.toml", "--formulation", "paper"], "which is no target X Y, needs --out DIR"),
        (["10", "5", "--formulation", "paper"], "expected a target X Y with --model, or a suite"),
        (["10", "5", "6"], "export is asked of '10 5 6'"),
    ],
)
def test_an_export_of_neither_a_target_nor_a_suite_is_refused(words, message):
    with pytest.raises(CommandError, match=message):
        asked("export", *words)
