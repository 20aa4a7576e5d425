"""Every benchmark runs: each once, at its smallest size, where no time is worth anything."""

from __future__ import annotations

import sys

import pytest

from benchmarks import harness
from benchmarks.__main__ import known, run

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", known())
def test_a_benchmark_runs_at_its_smallest_size(name, monkeypatch):
    """Skipped, with the reason, where all that it measures is a peer that is not installed."""
    monkeypatch.setattr(harness, "smallest", True)
    for module in [m for m in sys.modules if m.startswith(("benchmarks.bench_", "benchmarks.p"))]:
        monkeypatch.delitem(sys.modules, module)

    rows = list(run(name))

    assert [row.note for row in rows if row.failed] == []
    if all(row.ours is None for row in rows):
        pytest.skip("; ".join(row.note for row in rows))
