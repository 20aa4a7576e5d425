"""Whether the solvers that an experiment's file names may be asked, and where the file is wrong."""

from __future__ import annotations

import re

from dubins_study.experiments.definition.experiment import ExperimentError, ExperimentFile
from dubins_study.experiments.definition.messages import Problem, refusal
from dubins_study.experiments.definition.toml_lines import KeyPath
from dubins_study.experiments.plan.solver_specs import expand_solvers, untrusted_spec
from dubins_study.solvers.registry import SolverError

# the key that a message about an experiment begins with
_KEY = re.compile(r"(?:scenarios\.\d+|first)?(?:\.?(?:solvers|guess_lengths))?")


def check_solvers(file: ExperimentFile, trust_plugins: bool) -> None:
    """Refuse solvers that do not exist or have no such setting, all of a file at once.

    Plug-in files and programs on PATH are refused before, unless they are trusted: the file may
    come from anyone.

    Raises:
        ExperimentError, SolverError: naming key, line and spec, and what was expected.
    """
    lists = file.experiment.solver_lists()
    problems = [] if trust_plugins else _untrusted(file, lists)
    if problems:
        raise ExperimentError(refusal(file.path, problems, file.text))
    for path, specs in lists.items():
        for number, spec in enumerate(specs):
            try:
                expand_solvers([spec], file.experiment.profile)
            except SolverError as error:
                problems.append(_problem((*path, number), str(error)))
    if problems:
        raise SolverError(refusal(file.path, problems, file.text))


def _untrusted(file: ExperimentFile, lists: dict[KeyPath, list[str]]) -> list[Problem]:
    problems = []
    for path, specs in lists.items():
        for number, spec in enumerate(specs):
            try:
                untrusted = untrusted_spec([spec], file.experiment.profile)
            except SolverError:  # one of this package's, and wrong: told with the others
                continue
            if untrusted is not None:
                sentence = (
                    f"{untrusted} runs a program or file that is not this package's; expected "
                    "--trust-plugins, if you know what it is, or your own choice of --solver"
                )
                problems.append(_problem((*path, number), sentence))
    return problems


def _problem(path: KeyPath, sentence: str) -> Problem:
    return Problem(path, f"{'.'.join(map(str, path[:-1]))}: {sentence}")


def placed(
    error: ExperimentError | SolverError, file: ExperimentFile
) -> ExperimentError | SolverError:
    """The error with the file and, where its message begins with a key, the key's line."""
    match = _KEY.match(str(error))
    steps = match[0].split(".") if match else []
    path = tuple(int(step) if step.isdigit() else step for step in steps)
    return type(error)(refusal(file.path, [Problem(path, str(error))], file.text))
