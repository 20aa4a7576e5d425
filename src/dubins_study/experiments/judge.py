"""Judge the answers that another program wrote into a file, and keep them as a results folder."""

from __future__ import annotations

import hashlib
import json
import math
import re
import shlex
from collections import Counter
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple
from uuid import uuid4

from dubins_study.asking.reply import Reply, no_answer
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.definition.experiment import ExperimentFile, read
from dubins_study.experiments.definition.messages import Problem, refusal
from dubins_study.experiments.definition.table_file import Table, TableRow, read_table
from dubins_study.experiments.executors.local import row_of
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.plan.questions import Asked, questions
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.experiments.plan.scenarios import scenario_id
from dubins_study.experiments.run import new_manifest
from dubins_study.experiments.store.folder import compact, done, locked, open_folder, prepare_folder
from dubins_study.experiments.store.manifest_changes import RunRecord, count_cells
from dubins_study.experiments.store.part_writer import PartWriter, Progress
from dubins_study.solvers.protocol import MAX_ARCS, Method, Question, Solution
from dubins_study.study.kinds.table import pathless_kind_of, prepare
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import RunEntry, SolverEntry
from dubins_study.study.rows.parts import Row, row_key
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose
from dubins_study.study.values import did_you_mean, number_of_text, plain, real_number, short
from dubins_study.study.words import Claim, Outcome, Verdict

if TYPE_CHECKING:
    import pandas as pd

_REQUIRED = ("id", "curvatures", "lengths")
COLUMNS = (*_REQUIRED, "claim", "bound", "seconds", "start_heading", "method")
# A name stands where specs of solvers do, and must not read as one with settings.
_METHOD = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.+-]{0,59}")
_ELSEWHERE = "not known: the program told its seconds"  # the machine, so that no time is ranked


class AnswersError(DubinsStudyError, ValueError):
    """A file of answers that cannot be judged; names file, line, column and what was expected."""


class Given(NamedTuple):
    """An answer as the file has it, of the question with this id."""

    id: str
    method: str
    path: Path | None
    claim: Claim = Claim.NONE
    bound: float | None = None  # length unit
    seconds: float | None = None


def judge_answers(
    file: str | FilePath,
    suite: str = "benchmark-route",
    *,
    out: str | FilePath | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Judge the answers of a file to the questions of an experiment, by their controls alone.

    A question without an answer has a row too, with the outcome `not_asked`: it stays in every
    share.

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
    every = questions(experiment_file.experiment)
    asked = {id_: q for id_, q in every.items() if pathless_kind_of(q.branch) is None}
    if not asked:
        raise AnswersError(f"{suite} asks for points of convex problems; expected one of paths")
    answers = read_answers(FilePath(file), asked)
    digests = _digests(answers)
    profile = experiment_file.experiment.profile
    settings = RunSettings(uuid4().hex[:12], experiment_file.experiment.time_limit_s)
    settings = settings._replace(executor="file")
    rows: list[Row] = []
    for method, digest in digests.items():
        for id_, question in asked.items():
            cell = _cell(method, profile, digest, question)
            answer = answers.get((id_, method))
            rows.append({"id": id_} | _row(cell, answer, settings))
            if progress is not None:
                progress(len(rows), len(asked) * len(digests))
    if out is not None:
        command = ["dubins-study", "judge", str(file), "--suite", str(suite)]
        stored = [{name: row[name] for name in row if name != "id"} for row in rows]
        _store(FilePath(out), experiment_file, shlex.join(command), settings, digests, stored)
    return pd.DataFrame(rows)


def summary(rows: pd.DataFrame) -> list[dict[str, Any]]:
    """How many answers of each method have which verdict, and how many claims more than is true."""
    lines = []
    for method, of_method in rows.groupby("solver", sort=False):
        verdicts = of_method["verdict"].value_counts()
        line: dict[str, Any] = {"method": method, "questions": len(of_method)}
        line["answered"] = int((of_method["outcome"] == Outcome.RETURNED).sum())
        line |= {str(verdict): int(verdicts.get(verdict, 0)) for verdict in Verdict}
        line["false claims"] = int(of_method["false_claim"].sum())
        line["false bounds"] = int(of_method["false_bound"].sum())
        lines.append(line)
    return lines


def _cell(method: str, profile: str, digest: str, asked: Asked) -> Cell:
    return Cell(
        scenario_id=scenario_id(asked.scenario),
        solver=method,
        profile=profile,
        branch=asked.branch,
        initial_guess="cold",
        repeat=0,
        code_digest=digest,
        scenario=asked.scenario,
        method=Method(engine=method),
        time_limit_s=asked.time_limit_s,
    )


def _row(cell: Cell, answer: Given | None, settings: RunSettings) -> Row:
    """The judged row of an answer; machine and threads are not known."""
    reply = no_answer(Outcome.NOT_ASKED, "the file has no answer")
    if answer is not None:
        solution = Solution(answer.claim, path=answer.path, lower_bound=answer.bound)
        times = Times(None, answer.seconds, answer.seconds)
        reply = Reply(Outcome.RETURNED, solution, times)
    prepare(cell.scenario, cell.branch)
    question = Question(cell.scenario, cell.branch)
    row = row_of(cell, question, settings, reply._replace(versions="{}"))
    return row | {"machine": _ELSEWHERE, "threads": None}


def _digests(answers: dict[tuple[str, str], Given]) -> dict[str, str]:
    """By method the digest of its answers: other ones of the name make earlier rows stale."""
    texts: dict[str, list[str]] = {}
    for answer in answers.values():
        path = answer.path
        controls = None if path is None else (path.curvatures.tolist(), path.lengths.tolist())
        heading = None if path is None else path.start.heading
        rest = answer._replace(path=None)
        texts.setdefault(answer.method, []).append(repr((rest, controls, heading)))
    return {
        method: hashlib.sha256("\n".join(sorted(lines)).encode()).hexdigest()[:12]
        for method, lines in texts.items()
    }


def _store(
    folder: FilePath,
    file: ExperimentFile,
    command: str,
    settings: RunSettings,
    digests: dict[str, str],
    rows: list[Row],
) -> None:
    """Write the rows that a results folder does not hold yet."""
    solvers = {method: SolverEntry(code_digest=digest) for method, digest in digests.items()}
    prepare_folder(folder)
    with locked(folder):
        manifest, _ = open_folder(folder, new_manifest(file, command, solvers), restart=False)
        keys = {row_key(row) for row in rows}
        held = done(folder)
        totals = Counter((method, digest) for _, method, *_, digest in keys | held)
        manifest, completes = count_cells(manifest, set(solvers), totals)
        if keys <= held and manifest.finished:
            return
        entry = RunEntry(
            command=command,
            run_id=settings.run_id,
            executor=settings.executor,
            time_limit_s=settings.time_limit_s,
        )
        with RunRecord(folder, manifest, entry, completes):
            writer = PartWriter(folder, settings.run_id, len(keys), None)
            writer.skip(keys & held)
            writer.add(rows)
            writer.flush()
            compact(folder, settings.run_id)


def read_answers(file: FilePath, asked: dict[str, Asked]) -> dict[tuple[str, str], Given]:
    """The answers of a file, by id and method."""
    table = _json_table(file) if file.suffix == ".json" else read_table(file)
    problems = list(table.problems) or _column_problems(table)
    answers: dict[tuple[str, str], Given] = {}
    places: dict[tuple[str, str], str] = {}
    for row in () if problems else table.rows:
        try:
            answer = _given(row.values, asked, file.stem)
            key = answer.id, answer.method
            if key in answers:
                raise AnswersError(
                    f"id {answer.id} is answered by {answer.method!r} in {places[key]} already; "
                    "expected one answer of a method to each question"
                )
        except AnswersError as error:
            problems.append(f"{row.place}: {error}")
            continue
        answers[key] = answer
        places[key] = row.place
    if not (answers or problems):
        problems = ["no answers; expected a row each"]
    if problems:
        sentences = [Problem((), plain(problem)) for problem in problems]
        raise AnswersError(refusal(str(file), sentences))
    return answers


def _json_table(file: FilePath) -> Table:
    """The objects of a JSON file as rows."""
    expected = f"expected a list of objects with the keys {', '.join(COLUMNS)}"
    try:
        content = json.loads(file.read_text(encoding="utf-8-sig"))
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise AnswersError(f"{file}: {place}: {error.msg}; {expected}") from None
    except OSError as error:
        raise AnswersError(f"{file}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError):
        raise AnswersError(f"{file}: cannot be read: it is no JSON in UTF-8") from None
    if not isinstance(content, list) or not all(isinstance(each, dict) for each in content):
        raise AnswersError(f"{file}: it holds {short(content)}; {expected}")
    names = list(dict.fromkeys(name for each in content for name in each))
    rows = [TableRow(f"answer {n}", each) for n, each in enumerate(content, start=1)]
    return Table(names, rows, [])


def _column_problems(table: Table) -> list[str]:
    """What is wrong with the names of the columns, a sentence each."""
    names = table.names
    expected = f"expected {', '.join(_REQUIRED)} and, if wanted, {', '.join(COLUMNS[3:])}"
    problems = [f"missing column {name!r}; {expected}" for name in _REQUIRED if name not in names]
    for name in dict.fromkeys(names):
        if name not in COLUMNS:
            near = did_you_mean(name, [known for known in COLUMNS if known not in names])
            problems.append(f"unknown column {short(name)}; {near}{expected}")
        elif names.count(name) > 1:
            problems.append(f"column {name!r} appears twice")
    return problems


def _given(values: dict[str, Any], asked: dict[str, Asked], stem: str) -> Given:
    """The answer of a row."""
    id_ = values.get("id")
    if not isinstance(id_, str) or id_ not in asked:
        near = did_you_mean(id_, asked)
        expected = "expected an id of the suite's instances.csv, as `dubins-study export` writes it"
        raise AnswersError(f"id is {short(id_)}; {near}{expected}")
    method = values.get("method") or stem
    if not isinstance(method, str) or not _METHOD.fullmatch(method):
        expected = "expected a name of up to 60 letters, digits, spaces and _ . + -"
        raise AnswersError(f"method is {short(method)}; {expected}")
    claim = values.get("claim") or Claim.NONE
    if claim not in tuple(Claim):
        near = did_you_mean(claim, Claim)
        raise AnswersError(f"claim is {short(claim)}; {near}expected one of: {', '.join(Claim)}")
    seconds = _number("seconds", values.get("seconds"))
    if seconds is not None and seconds < 0:
        raise AnswersError(f"seconds is {seconds!r}; expected a number from 0 on")
    bound = _number("bound", values.get("bound"))
    return Given(id_, method, _path(values, asked[id_]), Claim(claim), bound, seconds)


def _path(values: dict[str, Any], asked: Asked) -> Path | None:
    """The path of a row; None where it has no controls."""
    curvatures = _numbers("curvatures", values.get("curvatures"))
    lengths = _numbers("lengths", values.get("lengths"))
    counts = [None if each is None else len(each) for each in (curvatures, lengths)]
    if counts[0] != counts[1]:
        of_curvatures, of_lengths = ("no" if count is None else count for count in counts)
        raise AnswersError(
            f"curvatures has {of_curvatures} numbers and lengths {of_lengths}; expected as many"
        )
    scenario = asked.scenario
    heading = _number("start_heading", values.get("start_heading"))
    if heading is not None and scenario.heading is not None:
        expected = "expected it empty: the question gives the heading"
        raise AnswersError(f"start_heading is {heading!r}; {expected}")
    if curvatures is None or lengths is None:
        return None
    if len(lengths) > MAX_ARCS:
        raise AnswersError(f"lengths has {len(lengths)} numbers; expected at most {MAX_ARCS}")
    if scenario.heading is not None:
        heading = scenario.heading
    if heading is None:
        raise AnswersError("start_heading is empty; expected the path's (rad): the start is free")
    return Path(Pose(scenario.x, scenario.y, heading), curvatures, lengths)


def _numbers(name: str, value: Any) -> list[float] | None:
    """The numbers of a list, or of a text with spaces between them; None of an empty cell."""
    if value is None or value == "":
        return None
    parts = value.split() if isinstance(value, str) else value
    if not isinstance(parts, list):
        raise AnswersError(f"{name} is {short(value)}; expected numbers, such as 1 0 -0.5")
    numbers = [_number(f"{name}, number {n},", part) for n, part in enumerate(parts, start=1)]
    return [math.nan if number is None else number for number in numbers]


def _number(name: str, value: Any) -> float | None:
    """A finite number; None of an empty cell."""
    if value is None or value == "":
        return None
    try:
        number = number_of_text(value) if isinstance(value, str) else real_number(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise AnswersError(f"{name} is {short(value)}; expected a finite number")
    return number
