"""An experiment about the scenarios of a file instead of its own."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.definition.experiment import (
    ExperimentError,
    ExperimentFile,
    validated,
)
from dubins_study.experiments.definition.scenario_block import ListedBlock
from dubins_study.experiments.definition.scenario_file import read_scenarios
from dubins_study.study.scenario import NUMBERS


def listed_experiment(
    scenarios: str, base: ExperimentFile | None, solvers: list[str] | None
) -> ExperimentFile:
    """The experiment that asks solvers about the scenarios of a file.

    Args:
        scenarios: the path of the file.
        base: the experiment whose solvers, branches and limits hold; None: the defaults.
        solvers: specs that replace those of `base`.

    Raises:
        ScenarioFileError, ExperimentError: naming file, line, value and what was expected.
    """
    frame = read_scenarios(scenarios)
    name = FilePath(scenarios).stem
    if name in (".", ".."):  # the results folder has this name
        raise ExperimentError(f"{scenarios}: expected a file with a name, such as drive.csv")
    digest = hashlib.sha256(frame[list(NUMBERS)].to_numpy().tobytes())
    digest.update("\0".join(frame["label"]).encode())
    # A folder that holds rows about other scenarios is another experiment.
    comment = f"# about {len(frame)} scenarios with the digest {digest.hexdigest()[:16]}\n"
    if base is None:
        question = "How well do the chosen solvers answer these scenarios?"
        keys = {"title": f"Scenarios of {name}", "question": question}
        text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
        fields: dict[str, Any] = {**keys, "solvers": solvers}
    else:
        title = f"{base.experiment.title}: scenarios of {name}"
        text, fields = base.text, dict(base.experiment)
        fields |= {"title": title, "first": None, "section": None, "matrix": False}
    block = ListedBlock(listed=frame)
    experiment = validated(scenarios, fields | {"scenarios": [block]})
    return ExperimentFile(name, scenarios, comment + text, experiment)
