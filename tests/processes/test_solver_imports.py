"""What is in memory after solvers were loaded and asked."""

from __future__ import annotations

import subprocess
import sys

_SCRIPT = """
import sys
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load, registered
from dubins_study.solvers.reply import ask
from dubins_study.study.scenario import Scenario

for name in registered():
    if name != "analytic":
        for branch in ("best", "LS"):
            ask(load(name), Question(Scenario(target_x=0.2, target_y=0.7), branch), 10.0)
answers = ("dubins_study.study.closed_form", "dubins_study.study.check")
print([name for name in sys.modules if name.startswith(answers)])
"""


def test_no_solver_but_the_closed_form_loads_the_answer_or_the_check():
    """Not even by an import that no source names, on a question without a path."""
    done = subprocess.run(
        [sys.executable, "-c", _SCRIPT], capture_output=True, text=True, timeout=120, check=True
    )

    assert done.stdout.splitlines()[-1] == "[]"
