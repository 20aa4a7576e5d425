"""The public names of the package.

Tested is which they are, and what they do together.
"""

import importlib
import inspect
import math
import pkgutil
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
from matplotlib.figure import Figure

import dubins_study
from dubins_study import (
    Claim,
    DubinsStudyError,
    Path,
    Scenario,
    available_solvers,
    compare,
    load_results,
    merge,
    plot_path,
    render,
    run,
    solve,
    status,
)

PUBLIC = {
    *("Scenario", "Path", "solve", "solve_frame", "plot_path", "available_solvers"),
    *("Mission", "read_mission"),
    *("run", "status", "merge", "load_results", "render", "compare"),
    *("Solver", "Question", "Solution", "Claim", "Guarantee", "Verdict", "DubinsStudyError"),
    "check_solver",
}


def test_the_names():
    """All of them are listed, found and documented."""
    assert set(dubins_study.__all__) == PUBLIC
    assert set(dir(dubins_study)) == PUBLIC | {"__version__"}
    for name in PUBLIC:
        thing = getattr(dubins_study, name)
        assert thing.__name__ == name
        assert thing.__doc__
    with pytest.raises(AttributeError, match="has no attribute 'solver'"):
        _ = dubins_study.solver


def test_every_refusal_has_one_base_class():
    """Every refusal has one base class.

    A public error class of the package that is no `DubinsStudyError` is an internal one.
    """
    internal = {"EngineError", "NotSolvedError"}
    internal |= {"SearchEndError", "SpentError"}  # they end a search
    errors = set()
    for module in pkgutil.walk_packages(dubins_study.__path__, "dubins_study."):
        if module.name.endswith("__main__"):
            continue
        loaded = importlib.import_module(module.name)
        errors |= {
            kind
            for name, kind in inspect.getmembers(loaded, inspect.isclass)
            if issubclass(kind, Exception) and kind.__module__ == module.name and name[0] != "_"
        }

    assert {kind.__name__ for kind in errors if not issubclass(kind, DubinsStudyError)} == internal
    assert {"ScenarioError", "SolverError", "ResultsError", "RunError", "ReportError"} <= {
        kind.__name__ for kind in errors
    }


def test_one_question():
    """The first lines of a newcomer."""
    answer = solve(Scenario(heading="120deg", target_x=10, target_y=5), solver="ipopt")

    assert (answer.word, answer.claim, answer.verdict) == ("RS", Claim.LOCAL, "optimal")
    assert answer.length == answer.travel_time == pytest.approx(11.8681, abs=1e-4)
    assert isinstance(answer.path, Path)
    assert "ipopt" in available_solvers()


def test_an_answer_prints_in_ten_lines():
    """Whatever the solver, with or without a path."""
    turning = solve(Scenario(target_x=-5, target_y=0.1), solver="turn-rate-qp")
    assert len(turning.path.lengths) == 50
    for answer in (turning, solve(Scenario(target_x=0, target_y=1), branch="LS")):
        lines = repr(answer).splitlines()
        assert len(lines) <= 10
        assert max(map(len, lines)) <= 100
        assert str(answer.verdict) in repr(answer)


def test_an_answer_prints_first_what_a_planner_reads():
    """An answer prints a planner's numbers first.

    Length and time come first, then verdict and proof; the solver is last.
    """
    lines = repr(solve(Scenario(target_x=9, target_y=4, speed=2))).splitlines()

    assert [line.split()[0] for line in lines[1:3]] == ["length", "verdict"]
    assert "proof proved" in lines[2]
    assert lines[-1].split()[0] == "solver"


def test_an_answer_lists_what_a_planner_needs():
    """An answer lists what a planner needs.

    Every listed name is there; the certificate has its fields, which stay the answer's too.
    """
    answer = solve(Scenario(target_x=9, target_y=4))
    certificate = answer.certificate

    assert {"length", "path", "order", "visits", "certificate"} <= set(dir(answer))
    assert len(dir(answer)) < 16
    assert all(hasattr(answer, name) for name in dir(answer))
    assert vars(certificate) == {name: getattr(answer, name) for name in vars(certificate)}
    assert certificate.proof == "proved"
    assert certificate.reference_low <= answer.length
    assert "solver" not in vars(certificate)


def test_an_answer_of_many_legs_prints_its_length():
    """An answer of many legs prints its length.

    It prints its time too, then as much of the word as fits; so does the caption of its drawing.
    """
    via = [(5 * i, i % 2) for i in range(1, 30)]
    answer = solve(Scenario(target_x=150, target_y=0, via=via, speed=3))
    numbers = f"length {answer.length}, travel time {answer.travel_time}, word "

    assert len(answer.word.split()) == 30
    assert f"\n  {numbers}{answer.word[:7]}" in repr(answer)
    assert " ... (30 legs)\n" in repr(answer)
    for drawing in (answer._repr_svg_(), answer.path._repr_svg_()):
        caption = fromstring(drawing)[3].text
        assert f"length {answer.length:.6g}" in caption
        assert len(caption) < 90


def test_a_notebook_shows_an_answer():
    """A notebook shows an answer.

    It shows the drawing of its path, below it what the check says; nothing where there is no path.
    """
    answer = solve(Scenario(heading="120deg", target_x=10, target_y=5))
    drawing = fromstring(answer._repr_svg_())
    caption = "optimal, length 11.8681, proof proved, RS"

    assert (drawing[0].text, drawing[3].text) == (caption, caption)
    assert drawing[1].get("d") == fromstring(answer.path._repr_svg_())[1].get("d")
    assert solve(Scenario(target_x=0, target_y=1), branch="LS")._repr_svg_() is None


def test_plot_path(tmp_path):
    """An answer or a path, shown or saved."""
    answer = solve(Scenario(heading=1, target_x=3, target_y=-2))
    assert plot_path(answer).axes
    for suffix in ("svg", "pdf", "png"):
        plot_path(answer.path, tmp_path / f"path.{suffix}")
        assert (tmp_path / f"path.{suffix}").stat().st_size > 1000


def test_plot_path_on_axes_of_ones_own(tmp_path):
    """`plot_path` draws on axes of one's own.

    The other axes, the figure's size and its layout stay as they are.
    """
    figure = Figure((7, 3))
    left, right = figure.subplots(1, 2)
    answers = (
        solve(Scenario(heading=1, target_x=3, target_y=-2)),
        solve(Scenario(target_x=9, target_y=0, via=[(4, 1)])),
    )
    for answer in answers:
        assert plot_path(answer, tmp_path / "both.png", ax=right) is figure

    assert not left.lines
    assert len(right.lines) > 4
    assert figure.get_size_inches().tolist() == [7, 3]
    assert (tmp_path / "both.png").stat().st_size > 1000
    with pytest.raises(DubinsStudyError, match="ax is 3; expected axes of matplotlib"):
        plot_path(answers[0], ax=3)


@pytest.mark.parametrize(
    ("curvature", "length"), [(math.nan, 1.0), (0.0, math.inf), (1e200, 1e200)]
)
def test_a_path_that_is_not_finite_is_not_drawn(curvature, length):
    with pytest.raises(DubinsStudyError, match="the path is not finite"):
        plot_path(Path((0, 0, 0), [curvature], [length]))


def test_a_long_path_is_drawn_by_its_arcs():
    """A long path is drawn by its arcs.

    No corner of the line turns by more than 3 degrees, of 60 turns on 2000 length units.
    """
    path = Path((0, 0, 0), [1.0, 0.0, -1.0, 0.0] * 30, [1.0, 30.0, 2.0, 30.0] * 30)
    line = max(plot_path(path).axes[0].lines, key=lambda line: len(line.get_xydata()))
    chords = np.diff(line.get_xydata(), axis=0)
    turned = np.diff(np.unwrap(np.arctan2(*chords.T[::-1])))

    assert np.abs(turned).max() < math.radians(3)


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("path.bmp", "file is 'path.bmp'; expected a name ending in .svg, .pdf or .png"),
        ("/nowhere/path.svg", "cannot write /nowhere/path.svg: No such file"),
    ],
)
def test_files_that_no_path_is_drawn_into(file, message):
    with pytest.raises(DubinsStudyError, match=message):
        plot_path(solve(Scenario(target_x=3, target_y=0)), file)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (run, (3,)),
        (status, (None,)),
        (merge, (3, "out")),
        (merge, (["a", 3], "out")),
        (merge, (["a", "b"], 3)),
        (load_results, (3,)),
        (load_results, ([None],)),
        (render, (3,)),
        (compare, (3, "a")),
    ],
)
def test_what_is_no_path_of_a_folder_or_file(function, arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DubinsStudyError, match=r"^\w+ is .*(3|None).*; expected "):
        function(*arguments)


def test_no_path_to_draw():
    with pytest.raises(DubinsStudyError, match="there is no path to draw: analytic returned none"):
        plot_path(solve(Scenario(target_x=0, target_y=1), branch="LS"))
