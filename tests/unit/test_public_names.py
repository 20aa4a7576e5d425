"""The public names of the package: which they are, and what they do together."""

import importlib
import inspect
import pkgutil
from xml.etree.ElementTree import fromstring

import pytest

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
    """A public error class of the package that is no `DubinsStudyError` is an internal one."""
    internal = {"EngineError", "UndecidedError"}
    internal |= {"SearchEndError"}  # it ends a search
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


def test_a_notebook_shows_an_answer():
    """The drawing of its path, below it what the check says; nothing where there is no path."""
    answer = solve(Scenario(heading="120deg", target_x=10, target_y=5))
    drawing, caption = fromstring(answer._repr_svg_()), "optimal, length 11.8681, proof proved, RS"

    assert (drawing[0].text, drawing[3].text) == (caption, caption)
    assert drawing[1].get("points") == fromstring(answer.path._repr_svg_())[1].get("points")
    assert solve(Scenario(target_x=0, target_y=1), branch="LS")._repr_svg_() is None


def test_plot_path(tmp_path):
    """An answer or a path, shown or saved."""
    answer = solve(Scenario(heading=1, target_x=3, target_y=-2))
    assert plot_path(answer).axes
    for suffix in ("svg", "pdf", "png"):
        plot_path(answer.path, tmp_path / f"path.{suffix}")
        assert (tmp_path / f"path.{suffix}").stat().st_size > 1000


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
    with pytest.raises(DubinsStudyError, match=r"^\w+ is (3|None); expected "):
        function(*arguments)


def test_no_path_to_draw():
    with pytest.raises(DubinsStudyError, match="there is no path to draw: analytic returned none"):
        plot_path(solve(Scenario(target_x=0, target_y=1), branch="LS"))
