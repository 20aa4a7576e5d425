"""An experiment's questions as files for other programs.

These programs are no plug-ins.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from io import StringIO
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.asking.attempt import Answer, judged
from dubins_study.asking.reply import Reply
from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.plan.questions import Asked, questions
from dubins_study.solvers.export import ExportError, texts_of
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.kinds.table import pathless_kind_of, prepare, reference_of
from dubins_study.study.rows.parts import os_errors_as
from dubins_study.study.scenario import COLUMNS
from dubins_study.study.tolerances import Tolerances, tolerances
from dubins_study.study.words import Claim, Outcome

INSTANCES = "instances.csv"
_CHECKED = ("reference_low", "reference_high", "length", "start_heading", "curvatures", "lengths")


class Exported(NamedTuple):
    """The result of `export_suite`."""

    folder: FilePath
    instances: int
    files: int
    open: list[str]  # ids of the instances whose shortest length is not proven
    left_out: dict[str, str]  # by id: why the formulation has no file of the instance


def export_suite(
    suite: str,
    formulation: str,
    out: str | FilePath,
    progress: Callable[[int, int], None] | None = None,
) -> Exported:
    """Write a file for each question of an experiment.

    The table `instances.csv` is written too.

    Args:
        suite: the name of a packaged experiment, or the path of a TOML file.
        formulation: `paper`, or the spec of a solver in `solvers.export.WRITERS`.
        out: a folder that is made if it is not there. In a folder of an earlier export files of
            the same names are replaced; one with anything else is refused.
        progress: called with the number of questions done and the number of all questions.

    Raises:
        ExperimentError, SolverError, ExportError: if the suite or the formulation is not valid, or
            no question of the suite can be written in the formulation.
        ResultsError: if the folder cannot be written.
    """
    file = read(suite)
    suite_questions = questions(file.experiment)
    texts = texts_of(formulation)
    allowed = tolerances(file.experiment.profile)
    folder = FilePath(out)
    exported = Exported(folder, instances=len(suite_questions), files=0, open=[], left_out={})
    rows: list[dict[str, Any]] = []
    with os_errors_as(f"cannot write to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        _check_folder(folder)
        for done, (id_, question) in enumerate(suite_questions.items(), start=1):
            names = []
            try:
                for end, text in texts(Question(question.scenario, question.branch)).items():
                    names.append(f"{id_}{end}")
                    (folder / names[-1]).write_text(text, encoding="utf-8")
            except ExportError as error:
                exported.left_out[id_] = str(error)
            exported = exported._replace(files=exported.files + len(names))
            row = _instance(id_, question, allowed) | {"files": " ".join(names)}
            if row["open"] == "true":
                exported.open.append(id_)
            rows.append(row)
            if progress is not None:
                progress(done, len(suite_questions))
        if not exported.files:
            reason = next(iter(exported.left_out.values()))
            raise ExportError(f"{suite} has no question for {formulation}: {reason}")
        (folder / INSTANCES).write_text(_table(rows), encoding="utf-8")
    return exported


def _check_folder(folder: FilePath) -> None:
    """Refuse a folder with files that are no export's."""
    names = sorted(path.name for path in folder.iterdir())
    table = folder / INSTANCES
    if names and not (table.is_file() and table.read_bytes().startswith(b"id,")):
        raise ExportError(f"{folder} holds {names[0]!r}, no export; expected an empty folder")


def best_known(question: Asked, allowed: Tolerances) -> Answer:
    """The check's shortest path, as a judged answer.

    The answer has the proven interval around the shortest length. A question about a frozen convex
    problem has no path.
    """
    scenario = question.scenario
    branch = question.branch
    path = None
    if pathless_kind_of(branch) is None:
        prepare(scenario, branch)
        path = reference_of(scenario, branch, allowed).path
    reply = Reply(Outcome.RETURNED, Solution(Claim.NONE, path))
    return judged("the check", Question(scenario, branch), reply, allowed)


def _instance(id_: str, question: Asked, allowed: Tolerances) -> dict[str, Any]:
    """Column -> text, for a row of the table.

    Lists are numbers with spaces between them, as in files of scenarios. `open` is `true` if the
    proven interval is wider than the tolerance.
    """
    scenario = question.scenario
    best = best_known(question, allowed)
    low = best.reference_low
    high = best.reference_high
    is_open = False
    if low is not None and high is not None:
        is_open = high - low > allowed.gap * max(low, scenario.radius)
    row = {"id": id_} | {name: getattr(scenario, name) for name in COLUMNS}
    row |= {"branch": question.branch, "time_limit_s": question.time_limit_s}
    row |= {name: getattr(best, name) for name in _CHECKED}
    row["open"] = is_open
    row["label"] = " ".join(scenario.label.split())  # each row of the table is one line
    if scenario.heading is None:
        row["heading"] = "free"
    return {name: _cell(value) for name, value in row.items()}


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return " ".join(map(repr, map(float, value)))
    if isinstance(value, float):
        return repr(value)
    return str(value)


def _table(rows: list[dict[str, Any]]) -> str:
    text = StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
