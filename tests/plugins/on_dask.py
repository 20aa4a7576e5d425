"""Plug-ins with slsqp's answers that harm their Dask worker.

They write and read files beside their own. The file `executor` says whether Dask asks them, and a
harm that is done once is done where the file `armed` is.
"""

import os
import signal
import time
from pathlib import Path

import psutil

from dubins_study.solvers.paper_nlp.nlp import Slsqp

HERE = Path(__file__).parent


def dask_worker():
    """Process id of the Dask worker, or None without Dask."""
    parents = psutil.Process().parents()
    if "dask" in (HERE / "executor").read_text():
        return parents[1].pid
    return None


class OnDask(Slsqp):
    """Does something before it answers a question."""

    def solve(self, model, limit):
        question = model.leg.question
        if question.scenario.label != "warm-up":
            self.before(question)
        return super().solve(model, limit)


class Naps(OnDask):
    def before(self, question):
        time.sleep(0.4)


class KillsOnce(OnDask):
    """The first solve ends the Dask worker that it works for."""

    def before(self, question):
        if (HERE / "armed").exists():
            (HERE / "armed").unlink()
            (HERE / "killed").write_text(str(dask_worker()))
            os.kill(dask_worker(), signal.SIGKILL)
            time.sleep(60)


class HangsOnce(OnDask):
    """The first solve hangs, and names its process and those above it.

    It outlives whoever kills only the solver's own process; the second time it would hang.
    """

    def before(self, question):
        if (HERE / "armed").exists():
            (HERE / "armed").unlink()
            (HERE / "pids").write_text(f"{dask_worker()} {os.getppid()} {os.getpid()}")
            time.sleep(3600)


class KillsEach(OnDask):
    """Ends every Dask worker that asks for the word LS."""

    def before(self, question):
        if question.branch == "LS":
            os.kill(dask_worker(), signal.SIGKILL)


class Notes(OnDask):
    """Appends a line with its process id to the file `pids`."""

    def before(self, question):
        with (HERE / "pids").open("a") as file:
            file.write(f"{os.getpid()}\n")
