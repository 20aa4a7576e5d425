"""The printed numbers, computed again by pandas.

They are those of the benchmark's page and of README, from the rows.
"""

from pathlib import Path as FilePath

import pytest

from benchmarks.recompute import main

ROOT = FilePath(__file__).parents[2]


@pytest.mark.slow
def test_pandas_alone_comes_to_the_same_numbers(benchmark_page, monkeypatch, capsys):
    """pandas alone comes to the same numbers.

    No line is marked, and there are as many as the tables have cells.
    """
    monkeypatch.chdir(ROOT)
    code = main([str(ROOT / "results" / "benchmark"), str(benchmark_page.parent)])
    lines = capsys.readouterr().out.splitlines()

    assert [line for line in lines if line.startswith("!")] == []
    assert code == 0
    assert len(lines) > 50
