"""A small finished run, made once.

Tests look at it or copy it.
"""

import shutil
from pathlib import Path

import pytest

from dubins_study import run
from tests.live_run import CELLS, quick_experiment


@pytest.fixture(scope="session")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> str:
    """File of a small experiment of the closed form.

    It has `CELLS` cells.
    """
    return str(quick_experiment(tmp_path_factory.mktemp("experiment"), CELLS, "analytic"))


@pytest.fixture(scope="session")
def original(experiment: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of its finished run.

    No test changes it.
    """
    return run(experiment, tmp_path_factory.mktemp("original") / "out")


@pytest.fixture
def folder(original: Path, tmp_path: Path) -> Path:
    """Copy of the finished run, for a test's changes."""
    return Path(shutil.copytree(original, tmp_path / "out"))
