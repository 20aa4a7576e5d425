"""A small finished run, made once, which tests look at or copy."""

from pathlib import Path

import pytest

from dubins_study import run
from tests.live_run import CELLS, quick_experiment


@pytest.fixture(scope="session")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The file of an experiment of `CELLS` cells of the closed form."""
    return str(quick_experiment(tmp_path_factory.mktemp("experiment"), CELLS, "analytic"))


@pytest.fixture(scope="session")
def original(experiment: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of its finished run, which no test changes."""
    return run(experiment, tmp_path_factory.mktemp("original") / "out")
