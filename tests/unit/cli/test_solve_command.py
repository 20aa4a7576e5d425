"""`dubins-study solve`: exit codes and printed results.

Results are printed beside a refused drawing too.
"""

import json
import math
import re
from importlib.metadata import version

import pytest

from dubins_study import Scenario, plot_path, solve
from dubins_study.report.path_plot import PlotError
from tests.unit.cli.conftest import asked, line_of

PATH, NO_PATH = ("solve", "10", "5"), ("solve", "0", "1", "--branch", "LS")


def test_the_json_object_of_a_route():
    """The JSON object of a route.

    Via points have negative coordinates, in their order; the drawing is refused after it is
    printed.
    """
    route = ("--via", "-4", "1", "--via=6", "-2", "--final-heading", "-pi/2")
    done = asked("solve", "-10", "5", *route, "--solver", "slsqp", "--json", raises=False)
    answer = json.loads(done.stdout)

    assert answer["via"] == [[-4, 1], [6, -2]]
    assert answer["final_heading"] == -math.pi / 2
    assert (answer["outcome"], answer["region"], answer["margin"]) == ("unsupported", None, None)
    assert done.exit_code != 0
    plain = json.loads(asked(*PATH, "--json").stdout)
    assert (plain["via"], plain["final_heading"]) == ([], None)


@pytest.mark.parametrize("options", [("--plot",), ("--json", "--plot"), ("--geojson",)])
def test_a_drawing_of_no_path(options, tmp_path):
    """A missing path cannot be drawn.

    The answer is printed all the same; one line says that nothing is drawn; the exit code is 1.
    """
    file = tmp_path / ("path.json" if "--geojson" in options else "path.svg")
    done = asked(*NO_PATH, *options, str(file))

    assert done.exit_code == 1
    assert "none exists" in done.stdout
    assert done.stderr == f"dubins-study: {file} is not written: there is no finite path\n"
    assert not file.exists()
    if "--json" in options:
        answer = json.loads(done.stdout)
        assert (answer["length"], answer["segments"]) == (None, [])


def test_strict():
    """Exit code 1 unless the verdict is optimal."""
    assert asked(*PATH, "--strict").exit_code == 0
    assert asked(*NO_PATH, "--strict").exit_code == 1
    assert asked(*NO_PATH).exit_code == 0


def test_the_text_names_what_it_shows():
    """The text names its numbers.

    Travel time is no time of the solver's, and every name has a column of its own.
    """
    lines = asked(*PATH, "--speed", "2").stdout.splitlines()

    assert "travel time 5.59864663148" in [line[:25] for line in lines]
    assert not any(line.startswith("time") for line in lines)


MISSES = {
    "Path(s.start, [0.0], [1.0])": "misses: the path ends 10.3 R from the target",
    "Path(s.start, [], [])": "misses: the path ends 11.2 R from the target",
    "Path(s.start, [2.0], [1.0])": "misses: the curvature is 1 / R beyond what the branch allows",
    "Path((1, 0, 0), [0.0], [1.0])": "misses: the path starts elsewhere",
    "Path(s.start, [0.0], [-1.0])": "misses: the path has a number that is not finite, or a length",
    "Path(s.start, [0.0], [1e16])": "misses: the path ends 1e+16 R from the target",
}


@pytest.fixture
def plugin(tmp_path):
    """`plugin(body)`: spec of a solver with this `solve`.

    `body` is the body of `solve`.
    """

    def written(body):
        file = tmp_path / "plugin.py"
        file.write_text(
            "from dubins_study import Claim, Path, Solution, Solver\n"
            "class Mine(Solver):\n"
            "    name = 'mine'\n"
            "    def solve(self, question, limit):\n"
            "        s = question.scenario\n"
            f"        {body}\n"
        )
        return f"{file}:Mine"

    return written


@pytest.mark.parametrize("path", MISSES)
def test_a_path_that_misses_says_why(path, plugin):
    done = asked(*PATH, "--solver", plugin(f"return Solution(Claim.LOCAL, {path})"))

    assert line_of("verdict", done.stdout).startswith(MISSES[path])
    assert "the target is the start" not in done.stdout
    assert "none: the target is the start" in asked("solve", "0", "0").stdout


def test_a_solver_that_raises_has_no_solve_time(plugin):
    """A solver that raises has no solve time.

    The time until it raised has a name of its own.
    """
    text = asked(*PATH, "--solver", plugin("raise ValueError('later')")).stdout

    assert "solve time" not in text
    assert re.fullmatch(r"[\d.e-]+ m?s", line_of("ended after", text))


def test_the_version():
    assert asked("--version").stdout == f"dubins-study {version('dubins-study')}\n"


@pytest.mark.parametrize("drawn", [3, None, "path", Scenario(target_x=1, target_y=0), type])
def test_only_answers_and_paths_are_drawn(drawn):
    with pytest.raises(PlotError, match=r"drawn is .*; expected an answer of solve, or a Path"):
        plot_path(drawn)


def test_the_text_has_segments_and_the_solve_time():
    """The text has segments and the solve time.

    It has turn, length and angle of each piece; the lengths of many pieces are in the JSON object.
    """
    text = asked(*PATH).stdout
    answer = json.loads(asked(*PATH, "--json").stdout)
    first, second = answer["segments"]

    angle = math.degrees(first["length"])
    assert line_of("segments", text) == (
        f"{first['turn']} {first['length']:.6g} ({angle:.4g} deg), S {second['length']:.6g}"
    )
    assert re.fullmatch(r"[\d.e-]+ m?s, after [\d.e-]+ m?s to build", line_of("solve time", text))
    many = asked(*PATH, "--solver", "turn-rate-qp[n=20]").stdout
    assert line_of("segments", many).endswith("and 16 more: --json lists them")


def labels(figure):
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_the_shortest_path_is_drawn_beside_a_longer_one():
    """The shortest path is drawn beside a longer one.

    The grid of four headings does not hold the shortest path.
    """
    scenario = Scenario(target_x=10, target_y=5)
    longer = solve(scenario, solver="heading-milp[headings=4]")
    assert longer.verdict == "longer"

    first, second = labels(plot_path(longer))
    assert first.startswith("shortest: LS, 11.2")
    assert second.startswith("heading-milp[headings=4]: ")
    assert len(labels(plot_path(solve(scenario)))) == 1
    assert len(labels(plot_path(longer.path))) == 1


@pytest.mark.parametrize("form", [(), ("--json",)])
def test_the_answer_is_printed_if_its_drawing_fails(form, tmp_path):
    """The answer is printed if its drawing fails.

    There is no room for the file: the answer comes, then the refusal.
    """
    (tmp_path / "path.svg").symlink_to("/dev/full")
    request = ("solve", "10", "5", *form, "--plot", str(tmp_path / "path.svg"))
    done = asked(*request, raises=False)

    assert isinstance(done.exception, PlotError)
    assert re.match(r"cannot write .*path.svg: No space left", str(done.exception))
    assert "11.197" in done.stdout
