"""All mistakes of an experiment's file at once: line, key, value, and the nearest name."""

from __future__ import annotations

import tomllib
from time import perf_counter

import pytest

from dubins_study.experiments.definition.experiment import ExperimentError, packaged, read
from dubins_study.experiments.definition.messages import key_lines, line_of
from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.solvers.registry import SolverError

MANY = '''# a comment [x]
title = "t # no"
quesion = """
two
lines"""
solvers = [
  "analytic", # one
  "slsqp[x=1.5]",
]
repeats = 1.5
branches = ["best", "ls"]
[[scenarios]]
target_x = { linear = [1, 2, true] }
target_y = 3.5
radios = 2
[first]
scenarios = 0
solvers = ["analytc"]
[[scenarios]]
target_x = 1
target_y = "12deg"
sample.method = "sobl"
sample.count = 3
sample.seed = -1
sample.ranges = {x = {linear=[1.5,
 2]}, "tar get" = { log = [0, 1] } }
'''
MISTAKES = [
    "line 3: quesion: unknown key; did you mean 'question'?",
    "line 8: solvers: solver 'slsqp' has no setting 'x'; it has: model,",
    "line 10: repeats is 1.5: expected a whole number",
    "line 11: branches is ['best', 'ls']: no branch named 'ls'; did you mean 'LS'? choose from",
    "line 13: scenarios.0.target_x.linear.2 is True: expected a whole number",
    "line 15: scenarios.0.radios: unknown key; did you mean 'radius'?",
    "line 17: first.scenarios is 0: expected a number of at least 1",
    "line 18: first.solvers: no solver named 'analytc'; did you mean 'analytic'? choose one of",
    "line 21: scenarios.1.target_y is '12deg': expected a number; texts such as '120deg' are for",
    "line 22: scenarios.1.sample.method is 'sobl': expected 'sobol' or 'latin hypercube'",
    "line 24: scenarios.1.sample.seed is -1: expected a number of at least 0",
    "line 25: scenarios.1.sample.ranges.'tar get'.log is [0, 1]: a logarithmic range",
]


def refusal_of(text, tmp_path, **request):
    file = tmp_path / "my.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises((ExperimentError, SolverError)) as error:
        plan_run(Request(str(file), **request))
    return str(error.value).removeprefix(f"{file}: ")


def test_all_mistakes_at_once(tmp_path):
    head, *mistakes = refusal_of(MANY, tmp_path).splitlines()

    assert head == f"{len(MISTAKES)} mistakes"
    assert len(mistakes) == len(MISTAKES)
    for line, expected in zip(mistakes, MISTAKES, strict=True):
        assert line.startswith(f"  {expected}")


def test_solvers_are_checked_together(tmp_path):
    """Plug-ins with the others; those that are not trusted are refused and not loaded."""
    text = (
        'title = "t"\nquestion = "q"\nsolvers = ["{ipopt,slsqp}[modl=joint]", "no.py:A"]\n'
        '[[scenarios]]\ntarget_x = 1\ntarget_y = 2\nsolvers = ["nlp["]\n'
    )

    plugins = {
        False: "  line 3: solvers: no.py:A runs a program or file that is not this package's; exp",
        True: "  line 3: solvers: solver 'no.py:A': no file 'no.py'; expected file.py:Class",
    }
    for trusted, plugin in plugins.items():
        head, *mistakes = refusal_of(text, tmp_path, trust_plugins=trusted).splitlines()
        assert head == "4 mistakes"
        for solver, mistake in zip(("ipopt", "slsqp"), mistakes, strict=False):
            assert mistake.startswith(
                f"  line 3: solvers: solver '{solver}' has no setting 'modl'; did you"
            )
        assert mistakes[2].startswith(plugin)
        assert mistakes[3].startswith(
            "  line 7: scenarios.0.solvers: solver 'nlp[': '[' is not closed"
        )


def test_the_line_of_a_scenario_that_no_vehicle_has(tmp_path):
    block = "[[scenarios]]\ntarget_x = 1\ntarget_y = 2\n"
    text = (
        f'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n{block}{block}radius = [1, 1e200]\n'
    )

    assert refusal_of(text, tmp_path).startswith(
        "line 7: scenarios.1, scenario 1: radius is 1e+200; expected a number from"
    )


ALL = """title = "t"
question = "q"
solvers = ["slsqp[model={words,jont}]", "turn-rate-qp[n=-5]", "no.py:A[n={1,2}]", "a{b"]
repeats = 0
[[scenarios]]
target_x = 10
radius = [1,
 -2, 0]
speed = { linear = [1, -1, 3] }
heading = "west"
[[scenarios]]
distance = -3
bearing = 1
target_x = 3
[[scenarios]]
arc = 1
margin = 1
target_z = 1
[[scenarios]]
[scenarios.sample]
method = "sobol2"
count = 1
seed = 1
[scenarios.sample.ranges]
target_x = { log = [1, 20] }
bearings = { linear = [0, 1] }
[[scenarios]]
[scenarios.sample]
method = "sobol"
count = 1
seed = 1
[scenarios.sample.ranges]
distance = { linear = [-1, 3] }
bearing = { linear = [0, 1] }
radius = { linear = [0, 1] }
"""
WAYS = "expected target_x and target_y, or distance and bearing, or arc and margin"
TOGETHER = [
    "line 3: solvers: solver 'slsqp[model=jont]': model is 'jont'; did you mean 'joint'? expe",
    "line 3: solvers: solver 'turn-rate-qp[n=-5]': n is -5; expected a whole number from 2",
    "line 3: solvers: no.py:A[n=1] runs a program or file that is not this package's; expected",
    "line 3: solvers: solver 'a{b': '{' is not closed",
    "line 4: repeats is 0: expected a number of at least 1",
    f"line 5: scenarios.0: {WAYS}",
    "line 7: scenarios.0.radius is [1, -2, 0]: expected a number above 0; got -2.0, 0.0",
    "line 9: scenarios.0.speed: expected a number above 0; got -1.0",
    "line 10: scenarios.0.heading is 'west': 'west' is not an angle",
    f"line 11: scenarios.1: {WAYS}",
    "line 12: scenarios.1.distance is -3: expected a number of at least 0 (a target behind has",
    "line 18: scenarios.2.target_z: unknown key; did you mean 'target_y'?",
    "line 21: scenarios.3.sample.method is 'sobol2': expected 'sobol' or 'latin hypercube'",
    "line 26: scenarios.3.sample.ranges.bearings: no such field; did you mean 'bearing'? expect",
    "line 33: scenarios.4.sample.ranges.distance: expected a number of at least 0 (a target beh",
    "line 35: scenarios.4.sample.ranges.radius: expected a number above 0; got 0.0",
]


def test_targets_solvers_and_signs_are_told_with_the_rest(tmp_path):
    """What needs a whole block, a solver that is made, or every value of an axis waits for none."""
    head, *mistakes = refusal_of(ALL, tmp_path).splitlines()

    assert head == f"{len(TOGETHER)} mistakes"
    for line, expected in zip(mistakes, TOGETHER, strict=True):
        assert line.startswith(f"  {expected}")
    assert mistakes[-2].endswith("got -1.0")


def test_an_invalid_file_has_no_power_over_the_time(tmp_path):
    """Ten thousand specs that would be a thousand each: the first thousand are tried."""
    line = ", ".join(['"slsqp[model={jont,' + ",".join("a" * 30) + ']"'] * 1000)
    braces = ", ".join(['"' + "{analytic,}" * 9 + '"'] * 10_000)
    for solvers in (line, braces):
        text = f'title = 1\nquestion = "q"\nsolvers = [{solvers}]\n'
        assert "title is 1: expected a text" in refusal_of(text, tmp_path)


def test_no_plugin_is_loaded_for_a_message(tmp_path):
    """Of an invalid file as of a valid one: its code may be anyone's."""
    plugin, mark = tmp_path / "rude.py", tmp_path / "mark"
    plugin.write_text(f"import pathlib\npathlib.Path({str(mark)!r}).touch()\n")
    specs = [f"{plugin}:A", f"{{analytic,{plugin}:A}}", f"{plugin}:A[n=1]", f"slsqp[x={plugin}:A]"]
    text = f"title = 1\nsolvers = {specs}\n"

    assert "title is 1" in refusal_of(text, tmp_path)
    assert not mark.exists()


def test_a_target_at_the_start_is_one(tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(
        'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n'
        "[[scenarios]]\ndistance = [0, 1]\nbearing = 0\n"
    )

    assert plan_run(Request(str(file))).rows == 2


def test_twenty_mistakes_are_enough(tmp_path):
    text = "".join(f"key{number} = 1\n" for number in range(50))

    lines = refusal_of(text, tmp_path).splitlines()
    assert len(lines) == 22
    assert lines[-1] == "  and 34 more"  # with four keys that are missing


def test_a_syntax_error_keeps_the_readers_line(tmp_path):
    assert "(at line 2, column 5)" in refusal_of('title = "t"\nx = \n', tmp_path)


def paths(value, path=()):
    """The path of every value of a TOML file, and the value."""
    yield path, value
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from paths(inner, (*path, key))
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from paths(inner, (*path, number))


@pytest.mark.parametrize("name", packaged())
def test_each_key_stands_on_its_line(name):
    """Of all packaged experiments: the line holds the key, or that of the table around it."""
    text = read(name).text
    lines, known = text.splitlines(), key_lines(text)
    for path, _ in paths(tomllib.loads(text)):
        if path and isinstance(path[-1], str):
            line = lines[line_of(path, known) - 1]
            assert path[-1] in line or path not in known, path


@pytest.mark.parametrize(
    "text", ["", "a = 1", '"a b".c = [[1], {d = 2}]', "[a]\n[a.b]\n[[a.c]]\nd=1"]
)
def test_every_value_has_a_line(text):
    known = key_lines(text)

    assert all(line_of(path, known) for path, _ in paths(tomllib.loads(text)) if path)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (".".join("k" * 20_000) + " = 1", "line 4: a key of more than 50 parts"),
        ("k" * 40_000 + " = 1", "line 4: '" + "k" * 80 + "': unknown key"),
        ('title2 = """' + (" " * 1000 + "\n") * 900 + '"""', "line 4: title2: unknown key"),
        ("x = 1" + "\n" * 2**25, "expected at most 1048576: list scenarios in a .csv or"),
    ],
)
def test_a_long_key_or_text_is_refused_in_a_moment(line, message, tmp_path):
    text = f'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n{line}\n'
    text += "[[scenarios]]\ntarget_x = 1\ntarget_y = 1\n"
    began = perf_counter()

    assert message in refusal_of(text, tmp_path)
    assert perf_counter() - began < 5  # 27 s and 17 s before there was a bound
