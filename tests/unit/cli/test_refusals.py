"""Requests that cannot be read are refused.

One line on stderr names the mistake, and the exit code is 2.
"""

import sys

import pytest
import typer

from dubins_study.cli import app

# words after `dubins-study` -> parts of the refusal
REFUSALS = {
    "slove": "No such command 'slove'. Did you mean 'solve', 'solvers'?; see dubins-study --help",
    "new slover a.py": "No such command 'slover'. Did you mean 'solver'?; see dubins-study new -",
    "--vresion": "No such option: --vresion (Possible options: --version)",
    "run paper --job 2": "No such option: --job (Possible options: --jobs, ",
    "run -3": "no experiment named '-3'; choose one of: ",
    "solve 1 2 -x": "No such option: -x; see dubins-study solve --help",
    "solve 1 2 -radius 4": "No such option: -r; see",
    "solve --via-file a.csv --origin 4 8": "No such option: --origin; see",
    "solve": "the target is missing, or a single number; expected X Y, or --via-file",
    "solve 1 2 --from a 0 0": "--from is 'a 0 0'; expected two numbers and a heading",
    "solve --raduis 40 1 2": "No such option: --raduis (Possible options: --radius)",
    "solve 1 2 --raduis=40": "No such option: --raduis (Possible options: --radius)",
    "solve 1 2 --from 0 0": "--from is '0 0'; expected X Y HEADING: start pose, e.g. 0 0 120deg",
    "solve 1 2 --from 0 0 --json": "--from is '0 0 --json'; expected X Y HEADING: start pose, ",
    "solve 1 2 --from 0 0 --radius 1": "--from is '0 0 --radius'; expected X Y HEADING: start po",
    "solve --from 0 0 -- 1 2": "--from is '0 0 --'; expected X Y HEADING: start",
    "solve --from 0 0 1 2": "expected X Y, or --via-file; --from takes X Y HEADING",
    "solve 1 2 --via 3": "--via is '3'; expected X Y: point to pass on the way",
    "solve 1 2 --via 3 a": "Invalid value for '--via': 'a'; expected a number",
    "solve 1 2 --via --json 3": "--via is '--json 3'; expected X Y: point to pass on the way",
    "solve 1 2 --via 0 0": "via point 1 is (0.0, 0.0), the same point as the one before it;",
    "solve 1 2 --radius 1 --radius 2": "--radius is given twice; expected it once; see",
    "solve 1 2 --solver slsqp --solver ipopt": "--solver is given twice; expected it once",
    "run paper --time-limit=5 --time-limit 6": "--time-limit is given twice; expected it once",
    "solve 10 5 7": "Got unexpected extra argument(s) (7); see dubins-study solve --help",
    "solve 10 5 --via 4 1 6 -2": "Got unexpected extra argument(s) (6 -2)",
    "solve 10 5 --time 5": "No such option: --time (Possible options: ",
    "solve 10 5 --time-limit inf": "--time-limit is inf; expected a finite number of seconds",
    "solve 1 2 --final-heading 90": "final_heading: 90 is more than a full turn; write 90deg, or 9",
    "solve 1 2 --from 0 0 N": "'N' is not an angle; expected e.g. 120deg, 2.0944 or 2pi/3, counter",
    "solve 1 2 --from 0 0 270": "or 270rad, counterclockwise from +x (east), so north is 90deg",
    "solve 1 2 --via 3 4 --branch LS": "branch 'LS' is none of a route; choose one of: best",
    "solve 1 2 --branch LSL": "branch 'LSL' is none of one leg with a free final heading; choose",
    "solve 1 2 --solver slsqp --via 3 4": "slsqp does not take: via points; it takes: free final",
    "solve 1 2 --radius": "--radius is ''; expected NUMBER: minimum turning radius, ",
    "solve 1 2 --radius 40m": "Invalid value for '--radius': '40m'; expected a number; see ",
    "solve 1e 2": "Invalid value for 'X': '1e' is no number",
    "solve 1 2 --json=yes": "Option '--json' does not take a value",
    "run paper --jobs 1.5": "Invalid value for '--jobs': Input should be a valid integer",
    "run paper --time-limit 5s": "Invalid value for '--time-limit': '5s'; expected a number",
    "run paper --out --restart": "--out is '--restart'; expected DIR: default: results/<",
    "run paper --solver slsqp --solver --json": "--solver is '--json'; expected SPEC: instead of",
    "run paper slsqp": "Got unexpected extra argument(s) (slsqp)",
    "run": "experiment is None; expected a name or the path of a .toml file",
    "run papr": "no experiment named 'papr'; did you mean 'paper'? choose one of",
    "run paper --executor desk": "executor is 'desk'; did you mean 'dask'? expected",
    "compare a": "Missing argument 'NEW'",
    "merge a b": "Missing option '--out'",
    "status a\x1b[31m": "a\\x1b[31m is no results folder",
    "solve nan 0": "target_x is nan; expected a finite number",
    "solve 1 2 --radius 0": "radius is 0.0; expected a number above 0",
    "solve 1 2 --from 0 0 east": "heading: 'east' is not an angle",
    "solve 1 2 --from 0 0 120": "write 120deg, or 120rad",
    "solve 1 2 --time-limit 0": "--time-limit is 0.0; expected a finite number of seconds above 0",
    "solve 1 2 --plot path.bmp": "expected a name ending in .svg",
    "solve 1 2 --plot /nowhere/path.svg": "cannot write /nowhere/path.svg",
    "solve 1 2 --solver turn-rate-qp --branch LR": "is unsupported: turn",
    "export 1 2 --model x": "model is 'x'; expected one of: paper, disj",
    "export 1 2 --format lp": "format is 'lp'; expected one of: nl, mod",
    "export 1 2 --order SRL": "order is 'SRL'; did you mean",
    "export 1 2 --out /nowhere/a.nl": "cannot write /nowhere/a.nl",
    # a misspelt radius would export another problem
    "export 1 2 --raduis 25": "No such option: --raduis (Possible options: --radius)",
    "run paper --jobs 0": "jobs is 0",
    "run paper --repeats 0": "dubins-study: repeats is 0: expected greater than or equal to 1",
    "run paper --memory-limit 0": "dubins-study: memory_limit_gib is 0.0: expected greater than",
    "report /nowhere": "/nowhere",
    # the nearest name
    "solve 1 2 --solver iptop": "no solver named 'iptop'; did you mean 'ipopt'? choose one of: ana",
    "solve 1 2 --solver ipopt[modl=words]": "no setting 'modl'; did you mean 'model'? it has: mod",
    "solve 1 2 --solver ipopt[model=jiont]": "is 'jiont'; did you mean 'joint'? expected one of: ",
    "solve 1 2 --solver turn-rate-qp[engine=piq]": "is 'piq'; did you mean 'piqp'? expected one o",
    "solve 1 2 --branch ls": "no branch named 'ls'; did you mean 'LS'? choose one of: best, LS",
    "solve 1 2 --profile acurate": "no profile named 'acurate'; did you mean 'accurate'? choose",
    # two requests in one
    "solve 3": "the target is missing, or a single number; expected X Y, or --via-file",
    "solve 3 4 --geojson solver.py": "--geojson: solver.py: expected a file .json or .geojson",
    "solve --via 1 2 --via-file no.csv": "--via and --via-file are given; expected one of them",
    "solve --via-file no.csv": "no.csv: cannot be read: No such file or directory",
    "audit nonesuch": "no audit of 'nonesuch'; choose one of: paper, kaya",
    "new experiment my.tml": "my.tml: expected a name of plain characters, such as my-exp",
    "new experiment no/where.toml": "cannot write no/where.toml: No such file or directory",
}


@pytest.mark.parametrize("line", REFUSALS)
def test_a_refusal_is_one_line_and_nothing_is_written(line, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["dubins-study", *line.split()])
    with pytest.raises(SystemExit, match="2"):
        app.main()
    written = capsys.readouterr()

    assert written.out == ""
    assert written.err.startswith("dubins-study: ")
    assert REFUSALS[line] in written.err
    assert written.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_the_old_word_for_the_executor_is_taken_with_a_hint(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dubins-study", "run", "paper", "--engine", "desk"])

    with pytest.raises(SystemExit) as stopped:
        app.main()
    hint, refusal = capsys.readouterr().err.splitlines()
    assert stopped.value.code == 2
    assert "--executor dask; the old word, engine, is taken for this release only" in hint
    assert "executor is 'desk'; did you mean 'dask'?" in refusal


def commands():
    """Every command and the words before it.

    Those of `new` are there too.
    """
    groups = [("", typer.main.get_command(app.app))]
    for words, group in groups:
        for name, command in group.commands.items():
            if hasattr(command, "commands"):
                groups.append((f"{name} ", command))
            else:
                yield f"{words}{name}", command


@pytest.mark.parametrize(
    ("words", "option"),
    [
        pytest.param(words, param, id=f"{words} {param.opts[0]}")
        for words, command in commands()
        for param in command.params
        if param.param_type_name == "option"
    ],
)
def test_a_slip_in_an_option_names_it_and_what_it_takes(words, option, monkeypatch, capsys):
    """A slip in an option names it.

    The message also says what the option takes. Two letters are swapped, or the value is missing:
    of every option of every command.
    """
    name = option.opts[0]
    swapped = f"--{name[3]}{name[2]}{name[4:]}"
    slips = {swapped: f"No such option: {swapped} (Possible options: "}
    if not option.is_flag:
        slips[name] = f"{name} is '--quiet'; expected {option.metavar}: {option.help}"
    for slip, refusal in slips.items():
        monkeypatch.setattr(sys, "argv", ["dubins-study", *words.split(), slip, "--quiet"])
        with pytest.raises(SystemExit, match="2"):
            app.main()

        assert capsys.readouterr().err.startswith(f"dubins-study: {refusal}")


@pytest.mark.parametrize("words", ["", "new"])
def test_a_group_without_a_command_shows_its_help(words, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dubins-study", *words.split()])
    with pytest.raises(SystemExit, match="2"):
        app.main()

    assert capsys.readouterr().err.startswith(f"Usage: dubins-study {words}".strip())


@pytest.mark.parametrize("words", ["run -h --jobs x", "solve -h", "new solver a b --help"])
def test_help_is_given_though_values_are_wrong_or_missing(words, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dubins-study", *words.split()])
    with pytest.raises(SystemExit, match="0"):
        app.main()

    assert capsys.readouterr().out.startswith("Usage: dubins-study")


@pytest.mark.parametrize(
    "words",
    [("-qv",), ("-v", "-v"), ("--", "-2", "-5"), ("--from", "-1", "-1", "-2pi/3"), ("--radius=2",)],
)
def test_what_is_no_mistake(words, monkeypatch, capsys):
    """Unusual but right requests are no mistakes.

    They are two options of one letter, a flag twice, targets behind `--`, and a start below zero.
    """
    target = () if "--" in words else ("1", "2")
    monkeypatch.setattr(sys, "argv", ["dubins-study", "solve", *target, *words])
    with pytest.raises(SystemExit, match="0"):
        app.main()

    assert "length" in capsys.readouterr().out
