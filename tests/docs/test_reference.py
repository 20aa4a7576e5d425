"""What the documentation generates from the package is complete and up to date."""

from __future__ import annotations

import json
import tomllib
from importlib.resources import files

import pytest
from jsonschema import Draft202012Validator

from dubins_study.experiments.definition.experiment import packaged
from dubins_study.experiments.definition.json_schema import SCHEMA_FILE, schema_text

FOLDER = files("dubins_study.experiments")
SCHEMA = FOLDER / SCHEMA_FILE


def test_the_schema_file_is_that_of_the_models():
    """Write it anew with the command in docs/reference/experiment.md."""
    assert SCHEMA.read_text(encoding="utf-8") == schema_text()


@pytest.mark.parametrize("name", packaged())
def test_every_packaged_experiment_is_valid_by_the_schema(name):
    """The schema is checked by another library than the one that reads experiments."""
    fields = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    validator = Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))

    assert not list(validator.iter_errors(fields))
    assert list(validator.iter_errors(fields | {"solver": ["ipopt"]}))  # the key is `solvers`
