"""Workers are forked from our own server.

The caller's processes are left alone.
"""

import json
import os
import subprocess
import sys

import pytest

from tests.faults.experiments import experiment
from tests.marked import left_behind, marked
from tests.plugin_files import spec

HONEST = spec("honest", "Honest")

# a caller's script that uses multiprocessing's fork server before or after a run
CALLER = """
import json, multiprocessing, sys, time
from dubins_study import run

def started():
    process = multiprocessing.get_context("forkserver").Process(target=time.sleep, args=(60,))
    process.start()
    return process

if __name__ == "__main__":
    before = started() if {before} else None
    run({experiment!r}, {out!r}, trust_plugins=True)
    mine = before or started()
    mine.terminate()
    mine.join(10)
    code = mine.exitcode
    mine.kill()
    print(json.dumps([code, [child.pid for child in multiprocessing.active_children()]]))
    sys.stdout.flush()
    {pause}
"""


def call(folder, solver, before, pause="pass"):
    """Run a script in a process of its own.

    Returns its output, and what it left alive.
    """
    asking = experiment(folder, ([solver, HONEST], 1))
    script = folder / "caller.py"
    names = {"experiment": str(asking), "out": str(folder / "out")}
    script.write_text(CALLER.format(before=before, pause=pause, **names))
    mark, marking = marked()
    ended = subprocess.run(
        [sys.executable, script],
        cwd=folder,
        env={**os.environ, **marking},
        capture_output=True,
        text=True,
        timeout=150,
    )
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout.splitlines()[-1]), left_behind(mark)


@pytest.mark.many(1)
@pytest.mark.parametrize("before", [False, True])
def test_the_callers_own_processes_end_at_sigterm(tmp_path, before):
    """The caller's own processes end at SIGTERM.

    Their fork server was started before the run or after it.
    """
    (code, children), alive = call(tmp_path, HONEST, before)

    assert code == -15
    assert children == []
    assert alive == []


@pytest.mark.many(1)
@pytest.mark.parametrize("before", [False, True])
def test_orphans_end_with_the_run(tmp_path, before):
    """Orphans end with the run.

    They do so not only when the caller ends: it says itself which of the noted processes still
    run.
    """
    pids = tmp_path / "pids"
    check = (
        "import psutil; "
        f"noted = [int(line) for line in open({str(pids)!r})]; "
        "print(json.dumps([p for p in noted if psutil.pid_exists(p) "
        "and psutil.Process(p).status() != 'zombie']))"
    )
    noted = spec("hostile_endless", "Noted", pids=pids)
    left, alive = call(tmp_path, noted, before, check)

    assert pids.read_text().split()
    assert left == []
    assert alive == []
