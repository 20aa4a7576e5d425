"""All mistakes of an experiment's file at once: its keys, its solvers, and what goes together."""

from __future__ import annotations

import re
from typing import Any

from pydantic import ValidationError

from dubins_study.experiments.definition.experiment import (
    Experiment,
    ExperimentError,
    ExperimentFile,
    file_problems,
    text_of,
)
from dubins_study.experiments.definition.messages import KeyPath, Problem, refusal
from dubins_study.experiments.definition.scenario_block import Block, tables
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.plan.scenario_columns import block_size
from dubins_study.experiments.plan.solver_description import (
    MOST_SPECS,
    describe_solver,
    untrusted_spec,
    written_out,
)
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.registry import SolverError

_UNTRUSTED = (
    "runs a program or file that is not this package's; expected --trust-plugins, if you know what "
    "it is, or your own choice of --solver"
)
_NO_GUESS = "takes no initial guess; expected only solvers that do, or *"


def solver_problems(fields: dict[str, Any], trust_plugins: bool) -> list[Problem]:
    """Solvers that do not exist, have no such setting, or cannot be asked what they are asked.

    Each is made with its settings, braces written out. Plug-in files and programs on PATH are
    refused unless they are trusted, since the file may come from anyone; none of them is loaded
    before.
    """
    profile = fields.get("profile")
    known = profile if isinstance(profile, str) and profile in PROFILES else "default"
    problems: list[Problem] = []
    left = MOST_SPECS  # a stranger's file may list any number
    for path, spec, needs_guess in _listed(fields):
        sentences: dict[str, str] = {}  # by what makes two of them one mistake
        try:
            for name in written_out([spec], ()):
                left -= 1
                if left < 0:
                    return problems
                if sentence := _sentence(name, known, trust_plugins, needs_guess):
                    kind = _UNTRUSTED if sentence.endswith(_UNTRUSTED) else sentence
                    sentences.setdefault(kind, sentence)
        except SolverError as error:  # the spec cannot be written out
            sentences[str(error)] = str(error)
        key = ".".join(map(str, path[:-1]))
        problems += [Problem(path, f"{key}: {sentence}") for sentence in sentences.values()]
    return problems


def _sentence(name: str, profile: str, trust_plugins: bool, needs_guess: bool) -> str | None:
    """What is wrong with one spec; None if nothing is."""
    try:
        if not trust_plugins and untrusted_spec([name], profile):
            return f"{name} {_UNTRUSTED}"
        solver = describe_solver(name, profile)
    except SolverError as error:
        return str(error)
    return f"{solver.spec} {_NO_GUESS}" if needs_guess and not solver.warm else None


def _listed(fields: dict[str, Any]) -> list[tuple[KeyPath, str, bool]]:
    """The path and the text of every spec of the file, and whether it is given a guess."""
    blocks = [(("scenarios", number), block) for number, block in tables(fields)]
    guided = any("guess_lengths" in b and "solvers" not in b for _, b in blocks)
    lists: list[tuple[KeyPath, Any, bool]] = [((), fields, guided)]
    if isinstance(fields.get("first"), dict):
        lists.append((("first",), fields["first"], False))
    lists += [(path, block, "guess_lengths" in block) for path, block in blocks]
    listed = []
    for path, table, needs_guess in lists:
        specs = table.get("solvers")
        if isinstance(specs, list):
            # `*` selects the solvers that take an initial guess
            needs_guess = needs_guess and "*" not in specs
            listed += [
                ((*path, "solvers", number), spec, needs_guess)
                for number, spec in enumerate(specs)
                if isinstance(spec, str) and spec != "*"
            ]
    return listed


# the key that a message about an experiment begins with
_KEY = re.compile(r"(?:scenarios\.\d+|first)?(?:\.?(?:solvers|guess_lengths))?")
_MOST_SEARCHED_AGAIN = 100_000  # scenarios, which take about a second
_MOST_CONFLICTS = 20  # as many as one refusal lists
# Keys that stand in for wrong ones, so that the others can be looked at.
_STAND_INS: dict[str, Any] = {"title": "t", "question": "q", "solvers": ["analytic"]}


def read_checked(name: str, trust_plugins: bool, own_solvers: bool = True) -> ExperimentFile:
    """Read an experiment as `definition.experiment.read`, and check all that a run needs of it.

    Of a valid file the scenarios are left to the plan of the run, which looks at all of them. The
    error names every wrong key, its line, its value and what was expected; it is a `SolverError`
    if all of them are solvers that cannot be made. `own_solvers`: whether they will be asked.
    """
    source = text_of(name)
    fields = source.fields()
    problems: list[Problem] = []
    try:
        experiment = Experiment.model_validate(fields)
    except ValidationError as error:
        problems = file_problems(error, fields)
    wrong = solver_problems(fields, trust_plugins) if own_solvers else []
    if not problems and not wrong:
        return ExperimentFile(*source, experiment)
    solvers_alone = not problems and not any("--trust-plugins" in p.sentence for p in wrong)
    usable = _usable(fields, {problem.path for problem in wrong})
    together = conflicts(usable) if usable is not None else []
    kind = SolverError if solvers_alone and not together else ExperimentError
    raise kind(refusal(source.path, problems + wrong + together, source.text))


def conflicts(experiment: Experiment) -> list[Problem]:
    """What does not go together in a valid experiment: the first mistake of each block.

    That is: scenarios that no vehicle has, warm cells in two sweeps, too many cells. A
    block in which one is found is replaced by another, so that the next one is found; in a large
    experiment, where that takes long, the first one alone is found.
    """
    problems: list[Problem] = []
    while len(problems) < _MOST_CONFLICTS:
        if problems and sum(map(block_size, experiment.blocks)) > _MOST_SEARCHED_AGAIN:
            return problems
        try:
            chains(experiment)
            return problems
        except (ExperimentError, SolverError) as error:
            problem = _placed(str(error))
            problems.append(problem)
        number = problem.path[1] if problem.path[:1] == ("scenarios",) else None
        if not isinstance(number, int):
            return problems
        if number < len(experiment.scenarios):
            blocks = list(experiment.scenarios)
            blocks[number] = _stand_in(number)
            experiment = experiment.model_copy(update={"scenarios": blocks})
        else:  # one that `first` adds
            problems[-1] = Problem(("first",), f"first: {problem.sentence}")
            experiment = experiment.model_copy(update={"first": None})
    return problems


def refused(file: ExperimentFile) -> ExperimentError:
    """The error that names all conflicts of an experiment that has some."""
    return ExperimentError(refusal(file.path, conflicts(file.experiment), file.text))


def _placed(message: str) -> Problem:
    """The problem that a message tells, at the key with which it begins."""
    match = _KEY.match(message)
    steps = match[0].split(".") if match and match[0] else []
    return Problem(tuple(int(step) if step.isdigit() else step for step in steps), message)


def _usable(fields: dict[str, Any], wrong_specs: set[KeyPath]) -> Experiment | None:
    """The experiment without its invalid keys, blocks and specs; blocks keep their numbers.

    None if no block is left. The fields are changed.
    """
    for *path, _, number in sorted(wrong_specs, key=lambda place: place[-1], reverse=True):
        table: Any = fields
        for step in path:
            table = table[step]
        del table["solvers"][number]
        if not table["solvers"]:  # one that is right stands in for all
            table["solvers"] = ["slsqp" if "guess_lengths" in table else "analytic"]
    for _ in range(2):  # what is valid by itself may not be beside a stand-in
        try:
            return Experiment.model_validate(fields)
        except ValidationError as error:
            places = {each["loc"][:2] for each in error.errors()}
        blocks = fields.get("scenarios")
        if not isinstance(blocks, list) or not blocks:
            return None
        wrong = {place[1] for place in places if place[:1] == ("scenarios",) and len(place) > 1}
        if len(wrong) == len(blocks):
            return None
        keys = {place[0] for place in places if place and place[0] != "scenarios"}
        kept = {key: value for key, value in fields.items() if key not in keys}
        stand_ins = {key: value for key, value in _STAND_INS.items() if key not in kept}
        mended = [_stand_in(n) if n in wrong else block for n, block in enumerate(blocks)]
        fields = {**kept, **stand_ins, "scenarios": mended}
        if () in places:  # the rule about the whole file is about `first`
            fields.pop("first", None)
    return None


def _stand_in(number: int) -> Block:
    """A block that shares no scenario with any other."""
    return Block(label=f"in place of block {number}", target_x=10.0, target_y=0.0)
