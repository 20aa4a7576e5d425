"""Every benchmark runs once at its smallest size.

No time is worth anything there.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.__main__ import known

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.slow

SMALLEST = """
import json, sys
from benchmarks import harness
harness.smallest = True
from benchmarks.__main__ import run
print(json.dumps([(row.note, row.failed, row.ours is None) for row in run(sys.argv[1])]))
"""


@pytest.mark.parametrize("name", known())
def test_a_benchmark_runs_at_its_smallest_size(name):
    """A benchmark runs at its smallest size.

    It is skipped, with the reason, where all that it measures is a peer that is not installed.
    """
    asked = [sys.executable, "-c", SMALLEST, name]
    done = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True)

    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout.splitlines()[-1])
    assert [note for note, failed, _ in rows if failed] == []
    if all(absent for _, _, absent in rows):
        pytest.skip("; ".join(note for note, _, _ in rows))
