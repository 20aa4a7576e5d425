"""The runs that many tests look at: made once, each in processes of its own."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pytest

from tests.faults import expected
from tests.faults.launch import Ended, experiment, rows, spec, study

HONEST = spec("honest", "Honest")
ASKED = 8  # questions to the honest solver, beside the hostile ones


class Shared(NamedTuple):
    """A finished run of hostile plug-ins beside an honest one."""

    ended: Ended
    rows: pd.DataFrame
    folder: Path
    scratch: Path


def shared_run(folder: Path, table: dict, asked: int, jobs: int, limit: float) -> Shared:
    """Every plug-in of a table asked so many questions, in one run."""
    scratch = folder / "scratch"
    scratch.mkdir()
    specs = [spec(*name.split(":"), **_settings(scratch, case)) for name, case in table.items()]
    asking = experiment(folder, (specs, asked), ([HONEST], ASKED))
    options = ("--jobs", jobs, "--limit", limit, "--memory", 2, "--out", folder / "out")
    ended = study("run", asking, *options, cwd=scratch, env={"TMPDIR": str(scratch)})
    assert (folder / "out" / "manifest.json").is_file(), ended.err
    return Shared(ended, rows(folder / "out"), folder / "out", scratch)


def _settings(scratch: Path, case: expected.Case) -> dict[str, Path]:
    """Files that a plug-in writes for the test to see."""
    return {name: scratch / name for name in case.files}


@pytest.fixture(scope="session")
def clean(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """What the honest solver answers where nobody else is asked."""
    folder = tmp_path_factory.mktemp("clean")
    asking = experiment(folder, ([HONEST], 1), ([HONEST], ASKED))
    ended = study("run", asking, "--out", folder / "out")
    assert ended.code == 0, ended.err
    found = rows(folder / "out")
    return found[found["label"] == "block 1"]


_JOBS = [2, pytest.param(1, marks=pytest.mark.slow)]


@pytest.fixture(scope="session", params=_JOBS, ids=lambda jobs: f"{jobs} jobs")
def quick(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """Plug-ins that crash, raise or answer nonsense at once."""
    table = expected.CRASHES | expected.RAISES | expected.ANSWERS
    return shared_run(tmp_path_factory.mktemp("quick"), table, 2, request.param, 10)


@pytest.fixture(scope="session", params=_JOBS, ids=lambda jobs: f"{jobs} jobs")
def endless(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """Plug-ins that never end."""
    return shared_run(tmp_path_factory.mktemp("endless"), expected.ENDLESS, 1, request.param, 0.5)


@pytest.fixture(scope="session", params=_JOBS, ids=lambda jobs: f"{jobs} jobs")
def greedy(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """Plug-ins that want all the memory."""
    return shared_run(tmp_path_factory.mktemp("greedy"), expected.MEMORY, 1, request.param, 30)
