"""Damaged results folders never give another number.

`tests/processes` makes them whole again.
"""

import random
import shutil
from pathlib import Path

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dubins_study import load_results
from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.rows.parts import ResultsError
from tests.fuzz.damage import DAMAGES
from tests.fuzz.hostile import LONG_LIVED

CELL = ["scenario_id", "solver", "branch"]
NUMBERS = ["length", "gap", "verdict", "proof"]


@pytest.fixture(scope="module")
def expected(small_run) -> pd.DataFrame:
    return read_rows(small_run.folder).to_pandas().set_index(CELL)[NUMBERS]


@pytest.fixture(scope="module")
def damaged(small_run, tmp_path_factory):
    """Makes a damaged copy of the small run.

    The copy has two parts and one damage.
    """
    place = tmp_path_factory.mktemp("damaged")
    number = 0

    def make(damage, seed: int) -> Path:
        nonlocal number
        number += 1
        folder = place / str(number)
        shutil.copytree(small_run.folder, folder)
        damage(folder, random.Random(seed))
        return folder

    return make


@settings(LONG_LIVED)
@given(damage=st.sampled_from(DAMAGES), seed=st.integers(0, 2**32 - 1))
def test_a_damaged_folder_never_gives_another_number(damage, seed, damaged, expected):
    """A damaged folder never gives another number.

    What is read of it stood there before; the rest is told.
    """
    folder = damaged(damage, seed)
    try:
        rows = load_results(folder).set_index(CELL)[NUMBERS]
    except ResultsError:
        pass
    else:
        assert (
            rows.sort_index()
            .astype(object)
            .equals(expected.loc[rows.index].sort_index().astype(object))
        )
    shutil.rmtree(folder)
