"""Judge another program's answers from a file.

The rows may be kept as a results folder.
"""

from __future__ import annotations

import hashlib
import shlex
from itertools import chain
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any
from uuid import uuid4

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError

from dubins_study.asking.reply import Reply, no_answer
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.definition.axes import StrictModel
from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.definition.messages import Problem, problems_of, refusal
from dubins_study.experiments.definition.table_file import (
    Table,
    TableRow,
    note_passed_over,
    read_table,
)
from dubins_study.experiments.executors.local import row_of
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.plan.questions import Asked, questions
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.experiments.plan.scenarios import scenario_id
from dubins_study.experiments.run import new_manifest
from dubins_study.experiments.store.folder import compact, done, locked, open_folder, prepare_folder
from dubins_study.experiments.store.manifest_changes import RunRecord, count_by_code, count_cells
from dubins_study.experiments.store.part_writer import PartWriter, Progress
from dubins_study.solvers.protocol import MAX_ARCS, Method, Solution
from dubins_study.solvers.registry import registered
from dubins_study.study.delimited import column_problems
from dubins_study.study.kinds.table import pathless_kind_of, prepare
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import Manifest, RunEntry, SolverEntry
from dubins_study.study.rows.parts import Row, os_errors_as, row_key
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose
from dubins_study.study.values import did_you_mean, nearest, plain, short
from dubins_study.study.words import Claim, Outcome

if TYPE_CHECKING:
    import pandas as pd

_REQUIRED = ("id", "curvatures", "lengths")  # the first columns of `COLUMNS`
_MACHINE = "not known: the program told its seconds"  # so that no time is ranked
_Finite = Annotated[float, Field(allow_inf_nan=False)]
_Numbers = Annotated[
    list[_Finite],
    Field(max_length=MAX_ARCS),
    BeforeValidator(lambda value: value.split() if isinstance(value, str) else value),
]


class AnswersError(DubinsStudyError, ValueError):
    """A file of answers cannot be judged.

    The message names file, line, column and what was expected.
    """


class Given(StrictModel):
    """An answer as a file has it.

    Lengths are in the scenario's unit.
    """

    id: str
    curvatures: _Numbers | None = None
    lengths: _Numbers | None = None
    claim: Claim = Claim.NONE
    bound: _Finite | None = None
    seconds: Annotated[_Finite, Field(ge=0)] | None = None
    start_heading: _Finite | None = None  # rad, where the scenario's is free
    # it stands in the column of solvers' specs, and must not read as a spec with settings
    method: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.+-]{0,59}$")]

    @property
    def key(self) -> tuple[str, str]:
        """Question and program."""
        return self.id, self.method


COLUMNS = tuple(Given.model_fields)
_UNANSWERED = no_answer(Outcome.NOT_ASKED, "the file has no answer")._replace(versions="{}")


def judge_answers(
    file: str | FilePath,
    suite: str = "benchmark-route",
    *,
    out: str | FilePath | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Judge a file's answers to an experiment's questions.

    An answer's path is judged by its controls alone. A question without an answer has a row too,
    with the outcome `not_asked`: it stays in every share.

    Args:
        file: a .csv file with the columns `COLUMNS`, lists with spaces between the numbers, or a
            .json file with a list of objects. No curvatures and lengths: no path was found.
        suite: the name or path of the experiment whose questions were answered.
        out: a results folder for the rows, new or of the same experiment; None for none.
        progress: called with the number of rows judged and the number of all rows.

    Returns:
        A row for each question and method, with `id` and the columns of `study.rows.schema`.

    Raises:
        AnswersError: naming each mistake's line and column, its value and what was expected.
        ExperimentError, ResultsError: if the experiment or the folder is not valid.
    """
    import pandas as pd

    experiment_file = read(suite)
    suite_questions = questions(experiment_file.experiment)
    with_paths = {
        id_: question
        for id_, question in suite_questions.items()
        if pathless_kind_of(question.branch) is None
    }
    if not with_paths:
        raise AnswersError(f"{suite} asks for points of convex problems; expected one of paths")
    answers = read_answers(FilePath(file), with_paths)
    # other answers of the same method make its earlier rows stale
    digest = hashlib.sha256(FilePath(file).read_bytes()).hexdigest()[:12]
    methods = list(dict.fromkeys(method for _, method in answers))
    profile = experiment_file.experiment.profile
    limit_s = experiment_file.experiment.time_limit_s
    settings = RunSettings(uuid4().hex[:12], limit_s, executor="file")
    ids: list[str] = []
    rows: list[Row] = []
    for method in methods:
        for id_, question in with_paths.items():
            cell = _cell(method, profile, digest, question)
            reply = answers.get((id_, method), _UNANSWERED)
            prepare(cell.scenario, cell.branch)
            row = row_of(cell, cell.question(), settings, reply)
            # the machine and the threads of another program are not known
            rows.append(row | {"machine": _MACHINE, "threads": None})
            ids.append(id_)
            if progress is not None:
                progress(len(rows), len(with_paths) * len(methods))
    if out is not None:
        command = ["dubins-study", "judge", str(file), "--suite", str(suite)]
        entries = {method: SolverEntry(code_digest=digest) for method in methods}
        manifest = new_manifest(experiment_file, shlex.join(command), entries)
        _store(FilePath(out), manifest, settings, rows)
    frame = pd.DataFrame(rows)
    frame.insert(0, "id", ids)
    return frame


def _cell(method: str, profile: str, digest: str, question: Asked) -> Cell:
    return Cell(
        scenario_id=scenario_id(question.scenario),
        solver=method,
        profile=profile,
        branch=question.branch,
        initial_guess="cold",
        repeat=0,
        code_digest=digest,
        scenario=question.scenario,
        method=Method(engine=method),
        time_limit_s=question.time_limit_s,
    )


def _store(folder: FilePath, new: Manifest, settings: RunSettings, rows: list[Row]) -> None:
    """Write the rows that a folder does not hold."""
    prepare_folder(folder)
    with locked(folder):
        manifest, _ = open_folder(folder, new, restart=False)
        keys = {row_key(row) for row in rows}
        done_keys = done(folder)
        totals = count_by_code(keys | done_keys)
        manifest, completes = count_cells(manifest, set(new.solvers), totals)
        if keys <= done_keys and manifest.finished:
            return
        entry = RunEntry(
            command=new.command,
            run_id=settings.run_id,
            executor=settings.executor,
            time_limit_s=settings.time_limit_s,
        )
        with RunRecord(folder, manifest, entry, completes):
            writer = PartWriter(folder, settings.run_id, len(keys), None)
            writer.skip(keys & done_keys)
            writer.add(rows)
            writer.flush()
            compact(folder, settings.run_id)


def read_answers(file: FilePath, by_id: dict[str, Asked]) -> dict[tuple[str, str], Reply]:
    """The answers of a file, by id and method.

    A row without a method has the file's name as its method. All mistakes are refused together.
    """
    table = _table(file)
    missing = [name for name in COLUMNS if name not in table.names]
    # Columns of another kind, such as those of instances.csv, are passed over. An unknown column
    # named like a missing one is likely a misspelling: it is refused.
    unrelated = [name for name in table.names if name not in COLUMNS and not nearest(name, missing)]
    names = [name for name in table.names if name not in unrelated]
    optional = COLUMNS[len(_REQUIRED) :]
    problems = table.problems + column_problems(names, _REQUIRED, optional)
    answers: dict[tuple[str, str], Reply] = {}
    places: dict[tuple[str, str], str] = {}
    rows = table.rows
    if problems:
        rows = []
    for row in rows:
        values = {
            name: cell
            for name, cell in row.values.items()
            if name in COLUMNS and cell not in (None, "")
        }
        try:
            answer = Given.model_validate({"method": file.stem} | values)
            path = _path(answer, by_id)
            if answer.key in places:
                raise AnswersError(
                    f"id {answer.id} of method {answer.method} is in {places[answer.key]} already; "
                    "expected one answer"
                )
        except ValidationError as error:
            problems += [f"{row.place}: {each.sentence}" for each in problems_of(error, {})]
        except AnswersError as error:
            problems.append(f"{row.place}: {error}")
        else:
            solution = Solution(answer.claim, path=path, lower_bound=answer.bound)
            times = Times(solve_s=answer.seconds, wall_s=answer.seconds)
            answers[answer.key] = Reply(Outcome.RETURNED, solution, times, versions="{}")
            places[answer.key] = row.place
    if not (answers or problems):
        problems = ["no answers; expected a row each"]
    if problems:
        sentences = [Problem((), plain(problem)) for problem in problems]
        raise AnswersError(refusal(str(file), sentences))
    note_passed_over(file, unrelated)
    return answers


def _table(file: FilePath) -> Table:
    """The rows of a CSV or JSON file."""
    if file.suffix != ".json":
        return read_table(file)
    with os_errors_as(f"{file} cannot be read"):
        text = file.read_bytes()
    try:
        content = TypeAdapter(list[dict[str, Any]]).validate_json(text)
    except ValidationError as error:
        sentences = "; ".join(each.sentence for each in problems_of(error, {}))
        raise AnswersError(f"{file}: {sentences}; expected a list of objects") from None
    names = list(dict.fromkeys((*_REQUIRED, *chain.from_iterable(content))))
    rows = [TableRow(f"answer {n}", each) for n, each in enumerate(content, start=1)]
    return Table(names, rows, [])


def _path(answer: Given, by_id: dict[str, Asked]) -> Path | None:
    """The path of an answer, or None.

    None if the answer has no controls. An answer with an unknown id, a method named like our
    solvers, or wrong controls is refused.
    """
    if answer.id not in by_id:
        near = did_you_mean(answer.id, by_id)
        expected = "expected an id of the suite's instances.csv, as `dubins-study export` writes it"
        raise AnswersError(f"id is {short(answer.id)}; {near}{expected}")
    if answer.method in registered():
        raise AnswersError(f"method is {answer.method!r}, a solver of ours; expected another name")
    scenario = by_id[answer.id].scenario
    if answer.curvatures is None and answer.lengths is None:
        return None
    curvatures = answer.curvatures or []
    lengths = answer.lengths or []
    if len(curvatures) != len(lengths):
        counts = f"curvatures has {len(curvatures)} numbers and lengths {len(lengths)}"
        raise AnswersError(f"{counts}; expected as many")
    heading = scenario.heading
    if heading is None:
        heading = answer.start_heading
        if heading is None:
            expected = "expected a number (rad): the start is free"
            raise AnswersError(f"start_heading is None; {expected}")
    elif answer.start_heading is not None:
        raise AnswersError(f"start_heading is {answer.start_heading}; expected it empty")
    return Path(Pose(scenario.x, scenario.y, heading or 0.0), curvatures, lengths)  # 0.0 of -0.0
