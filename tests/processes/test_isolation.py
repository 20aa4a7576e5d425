"""What one solver does to its process reaches no other solver's rows."""

from __future__ import annotations

import os
import threading

import pytest

from dubins_study import run
from dubins_study.experiments.isolation.sandbox import pinned_threads
from dubins_study.experiments.store.folder import read_rows

PLUGINS = """
import os
import scipy.optimize
from dubins_study.solvers.analytic import Analytic
KEPT = []
class Patches(Analytic):
    def solve(self, model, limit):
        scipy.optimize.minimize = None
        return super().solve(model, limit)
class Slips(Analytic):
    def solve(self, model, limit):
        if os.fork() == 0:
            os.execv("/nonexistent", ["x"])  # the child falls out of solve
        os.wait()
        return super().solve(model, limit)
class Forgets(Analytic):
    def solve(self, model, limit):
        solution = super().solve(model, limit)
        os.fork()  # both go on
        return solution
class Leaks(Analytic):
    def solve(self, model, limit):
        KEPT.append(bytearray(150 * 2**20))
        return super().solve(model, limit)
class OpensFiles(Analytic):
    def solve(self, model, limit):
        KEPT.extend(open(os.devnull) for _ in range(40))
        return super().solve(model, limit)
"""
TEXT = """
title = "isolation"
question = "?"
solvers = ["slsqp"]
time_limit_s = 5
memory_limit_gib = 1.0
repeats = 6
[[scenarios]]
target_x = 3
target_y = [1, 2]
"""


@pytest.mark.parametrize("name", ["Patches", "Slips", "Forgets", "Leaks", "OpensFiles"])
def test_every_row_is_right(tmp_path, name):
    (tmp_path / "plugins.py").write_text(PLUGINS)
    (tmp_path / "isolation.toml").write_text(TEXT)
    spec = f"{tmp_path}/plugins.py:{name}"
    folder = run(tmp_path / "isolation.toml", tmp_path / "out", solvers=[spec, "slsqp"])
    rows = read_rows(folder).to_pandas()

    assert len(rows) == 24
    assert set(rows["outcome"]) == {"returned"}
    assert set(rows["verdict"]) == {"optimal"}


def test_two_threads_that_pin_give_the_environment_back(monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    inside, leave = threading.Event(), threading.Event()

    def other():
        with pinned_threads():
            inside.set()
            leave.wait()

    thread = threading.Thread(target=other)
    with pinned_threads():
        thread.start()
        inside.wait()
    assert os.environ["OMP_NUM_THREADS"] == "1"
    leave.set()
    thread.join()

    assert "OMP_NUM_THREADS" not in os.environ
