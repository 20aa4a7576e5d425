"""The keys of an experiment's TOML file as a JSON schema, which editors complete and check by."""

from __future__ import annotations

import json
from typing import Any

from dubins_study.experiments.definition.experiment import Experiment

# Beside the packaged experiments; `tests/docs/test_reference.py` compares it with the models.
SCHEMA_FILE = "experiment.schema.json"


def json_schema() -> dict[str, Any]:
    """The schema (draft 2020-12) of an experiment; values' own rules stay with the models."""
    schema = Experiment.model_json_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "An experiment of dubins-study",
    }


def schema_text() -> str:
    """The schema as the text of `SCHEMA_FILE`."""
    return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"
