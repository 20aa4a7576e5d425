"""Twenty files with many mistakes of different kinds: each is named once, on its line, in order.

The files lie in `mistakes`; where a line holds a mistake, its comment begins with WRONG and holds
the beginning of the sentence, `||` between two. A comment on its own names a mistake that has no
line, such as a key that is missing.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.solvers.registry import SolverError

FOLDER = Path(__file__).parent / "mistakes"
FILES = sorted(FOLDER.glob("*.toml"))


def expected_mistakes(text):
    for number, line in enumerate(text.splitlines(), 1):
        code, mark, sentences = line.partition("# WRONG: ")
        for sentence in sentences.split(" || ") if mark else ():
            yield f"line {number}: {sentence}" if code else sentence


def test_every_file_is_there():
    assert len(FILES) == 20


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_mistake_is_named_once_on_its_line(file, monkeypatch):
    monkeypatch.chdir(FOLDER)
    expected = list(expected_mistakes(file.read_text(encoding="utf-8")))
    with pytest.raises((ExperimentError, SolverError)) as refusal:
        plan_run(Request(file.name, trust_plugins=True))

    head, *mistakes = str(refusal.value).split("\n  ")
    assert head == f"{file.name}: {len(expected)} mistakes", "\n".join(mistakes)
    for mistake, beginning in zip(mistakes, expected, strict=True):
        assert mistake.startswith(beginning)


def test_a_byte_order_mark_is_no_mistake(tmp_path):
    """Editors of Windows write one."""
    file = tmp_path / "marked.toml"
    text = 'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n[[scenarios]]\ntarget_x = 3\n'
    file.write_text(text + "target_y = 2\n", encoding="utf-8-sig")

    assert len(plan_run(Request(str(file))).keys) == 1
