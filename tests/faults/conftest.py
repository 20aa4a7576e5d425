"""Runs that many tests share.

Each is made once, in processes of its own.
"""

from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pytest

from tests.faults import expected
from tests.faults.experiments import experiment, rows
from tests.live_run import Ended, study
from tests.plugin_files import spec

HONEST = spec("honest", "Honest")
ASKED = 8  # questions to the honest solver, beside the hostile ones


class Shared(NamedTuple):
    """A finished run of hostile and honest plug-ins."""

    ended: Ended
    rows: pd.DataFrame
    folder: Path
    scratch: Path
    table: dict[str, expected.Case]
    asked: int
    limit: float


def shared_run(folder: Path, table: dict, asked: int, jobs: int, limit: float) -> Shared:
    """Run every plug-in of a table.

    Each is asked so many questions, all in one run.
    """
    scratch = folder / "scratch"
    scratch.mkdir()
    specs = [spec(*name.split(":"), **_settings(scratch, case)) for name, case in table.items()]
    asking = experiment(folder, (specs, asked), ([HONEST], ASKED))
    options = ("--jobs", jobs, "--time-limit", limit, "--memory-limit", 2, "--out", folder / "out")
    ended = study("run", asking, "--trust-plugins", *options, cwd=scratch, TMPDIR=str(scratch))
    assert (folder / "out" / "manifest.json").is_file(), ended.err
    return Shared(ended, rows(folder / "out"), folder / "out", scratch, table, asked, limit)


def _settings(scratch: Path, case: expected.Case) -> dict[str, Path]:
    """Files that a plug-in writes for the test."""
    return {name: scratch / name for name in case.files}


@pytest.fixture(scope="session")
def clean(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """Answers of the honest solver alone.

    Nobody else is asked in that run.
    """
    folder = tmp_path_factory.mktemp("clean")
    asking = experiment(folder, ([HONEST], 1), ([HONEST], ASKED))
    ended = study("run", asking, "--trust-plugins", "--out", folder / "out")
    assert ended.code == 0, ended.err
    answers = rows(folder / "out")
    return answers[answers["label"] == "block 1"]


# tables of hostile plug-ins: questions to each, limit (s)
TABLES = {
    "quick": (expected.CRASHES | expected.RAISES | expected.ANSWERS, 2, 10.0),
    "endless": (expected.ENDLESS, 1, 0.5),
    "stuck": (expected.STUCK, 1, 0.5),
    "greedy": (expected.MEMORY, 1, 30.0),
}


@pytest.fixture(scope="session")
def runs() -> dict[tuple[str, int], Shared]:
    """Cache of the runs made so far.

    pytest would make a run again for every test that comes back to it.
    """
    return {}


@pytest.fixture
def shared(
    request: pytest.FixtureRequest,
    runs: dict[tuple[str, int], Shared],
    tmp_path_factory: pytest.TempPathFactory,
) -> Shared:
    """The run of one table with some jobs.

    The parameter holds both.
    """
    kind, jobs = request.param
    if request.param not in runs:
        table, asked, limit = TABLES[kind]
        folder = tmp_path_factory.mktemp(kind)
        runs[request.param] = shared_run(folder, table, asked, jobs, limit)
    return runs[request.param]
