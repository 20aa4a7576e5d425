"""All mistakes of an experiment's file at once.

A message has line, key, value, and the nearest name.

The files in `mistakes` have many mistakes of different kinds. Where a line holds a mistake, its
comment begins with WRONG and holds the beginning of the sentence, `||` between two. A comment on
its own names a mistake that has no line, such as a key that is missing.
"""

import tomllib
from pathlib import Path

import pytest

from dubins_study.experiments.definition.experiment import ExperimentError, packaged, read
from dubins_study.experiments.definition.messages import line_of
from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.experiments.plan.solver_description import expand_solvers
from dubins_study.solvers.registry import SolverError
from dubins_study.study.specs import MOST_SPECS

FOLDER = Path(__file__).parent / "mistakes"
FILES = sorted(FOLDER.glob("*.toml"))
HEAD = 'title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n'
BLOCK = "[[scenarios]]\ntarget_x = 3\ntarget_y = 2\n"


def expected_mistakes(text):
    for number, line in enumerate(text.splitlines(), 1):
        code, mark, sentences = line.partition("# WRONG: ")
        for sentence in sentences.split(" || ") if mark else ():
            yield f"line {number}: {sentence}" if code else sentence


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_mistake_is_named_once_on_its_line(file, monkeypatch):
    """Every mistake is named once on its line.

    There are keys, values, targets, signs, solvers and conflicts, in the order of their lines.
    """
    monkeypatch.chdir(FOLDER)
    expected = list(expected_mistakes(file.read_text(encoding="utf-8")))
    with pytest.raises(ExperimentError) as refusal:
        plan_run(Request(file.name, trust_plugins=True))

    head, *mistakes = str(refusal.value).split("\n  ")
    assert head == f"{file.name}: {len(expected)} mistakes", "\n".join(mistakes)
    for mistake, beginning in zip(mistakes, expected, strict=True):
        assert mistake.startswith(beginning)


def refusal_of(text, tmp_path, **request):
    file = tmp_path / "my.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ExperimentError) as error:
        plan_run(Request(str(file), **request))
    return str(error.value).removeprefix(f"{file}: ")


def test_no_plugin_is_loaded_for_a_message(tmp_path):
    """No plug-in is loaded for a message.

    Neither an invalid file's nor a valid one's is loaded: its code may be anyone's.
    """
    plugin = tmp_path / "rude.py"
    mark = tmp_path / "mark"
    plugin.write_text(f"import pathlib\npathlib.Path({str(mark)!r}).touch()\n")
    specs = [f"{plugin}:A", f"{{analytic,{plugin}:A}}", f"{plugin}:A[n=1]", f"slsqp[x={plugin}:A]"]
    message = refusal_of(f"title = 1\nsolvers = {specs}\n", tmp_path)

    assert "title is 1" in message
    assert f"{plugin}:A runs a program or file that is not this package's; expected" in message
    assert not mark.exists()


def test_values_of_a_request_have_no_line(tmp_path):
    """Values of a request have no line.

    Nor are they the file's: each is named by its key, and the file's mistakes wait.
    """
    (file := tmp_path / "my.toml").write_text(f"repeats = 3\nseed = -1\n{HEAD}{BLOCK}")
    with pytest.raises(ExperimentError) as error:
        plan_run(Request(file, repeats=0, time_limit=-1.0))

    assert str(error.value) == (
        "repeats is 0: expected greater than or equal to 1; "
        "time_limit_s is -1.0: expected greater than 0"
    )


def test_twenty_mistakes_are_enough(tmp_path):
    lines = refusal_of("".join(f"key{number} = 1\n" for number in range(50)), tmp_path).splitlines()

    assert len(lines) == 22
    assert lines[-1] == "  and 34 more"  # with four keys that are missing


def paths(value, path=()):
    """Path of every value of a TOML file.

    The value comes with it.
    """
    yield path, value
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from paths(inner, (*path, key))
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from paths(inner, (*path, number))


@pytest.mark.parametrize("name", packaged())
def test_each_key_stands_on_its_line(name):
    """Each key stands on its line.

    All packaged experiments are read; the lines of a table's blocks are in their order.
    """
    text = read(name).text
    lines = text.splitlines()
    blocks = []
    for path, _ in paths(tomllib.loads(text)):
        if path and isinstance(path[-1], str):
            assert path[-1] in lines[line_of(path, text) - 1], path
        elif path[:1] == ("scenarios",) and len(path) == 2:
            blocks.append(line_of(path, text))

    assert blocks == [number for number, line in enumerate(lines, 1) if line == "[[scenarios]]"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("x = ", "not TOML: Invalid value (at line 4, column 5)"),
        ("radius = " + "[" * 5000, "not TOML"),
        ("k" * 40_000 + " = 1", "line 4: " + "k" * 120 + ": unknown key"),
        ('"a\\nb\\u001b" = 1', "a\\nb\\x1b: unknown key"),
        (f"seed = 0x{'f' * 9000}", "line 4: seed is a value of type int: expected less"),
        (f"branches = ['{'[' * 9000}']", "line 4: branches.0 is '[[["),
        ('title2 = """' + (" " * 1000 + "\n") * 900 + '"""', "line 4: title2: unknown key"),
    ],
)
def test_a_long_key_or_text_is_refused_in_a_moment(line, message, tmp_path):
    refusal = refusal_of(f"{HEAD}{line}\n{BLOCK}", tmp_path)  # pytest's limit is a minute

    assert message in refusal
    assert refusal.isprintable()
    assert len(refusal) < 600


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("{analytic,}" + "{,}" * 40, f"more than {MOST_SPECS} specs"),  # a million million
        ("turn-rate-qp[n={{10,20},30}]", "brackets do not match"),
        ("turn-rate-qp[n={10,20]", "brackets do not match"),
        ("turn-rate-qp[n={10,20}", "brackets do not match"),
    ],
)
def test_braces_do_not_multiply_without_end(spec, message):
    with pytest.raises(SolverError, match=message):
        expand_solvers([spec])


def test_what_windows_editors_write_is_no_mistake(tmp_path):
    """Windows editors' habits are no mistakes.

    The habit is a byte order mark. A target at the start is a target, too.
    """
    file = tmp_path / "marked.toml"
    file.write_text(f"{HEAD}[[scenarios]]\ndistance = [0, 1]\nbearing = 0\n", encoding="utf-8-sig")

    assert len(plan_run(Request(str(file))).keys) == 2


@pytest.mark.parametrize("name", ["..toml", "...toml", "nope"])
def test_a_name_that_leads_out_of_the_results_is_none(name, tmp_path, monkeypatch):
    """`results/..` is where somebody works."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(HEAD + BLOCK)

    with pytest.raises(ExperimentError, match=r"no experiment named .*; choose one of: "):
        read(name)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(ExperimentError, match="cannot be read: No such file"):
        read(str(tmp_path / "nope.toml"))
    (tmp_path / "latin.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ExperimentError, match="cannot be read: it is not UTF-8 text"):
        read(str(tmp_path / "latin.toml"))
