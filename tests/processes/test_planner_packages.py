"""Packages that a planner of paths must install.

Messages name those that are missing.
"""

import json
import re
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from dubins_study.cli.terminal.missing import refuse_missing
from tests.live_run import interpreted, output

PAGE = Path(__file__).parents[2] / "docs" / "flights.md"
POINTS = "x,y,name\n0,50,a\n40,80,b\n90,20,c\n-30,60,d\n"
ROUTE = "solve 10 5 --via 4 1 --via 6 -2 --final-heading 90deg"
# Commands of a planner; a mission file's formats and files out belong here too.
PLANS = (
    "--version",
    "solve 10 5",
    "solve 10 5 --json --geojson leg.json",
    ROUTE,
    "solve --via-file points.csv --radius 10 --from 0 0 free --order free --closed --json",
    "export 10 5 --format mod",
)
# A command that needs more -> the package that it names first.
NEED_MORE = {
    "solve 10 5 --plot path.svg": "matplotlib",
    "solve 10 5 --solver slsqp": "psutil",
    "run paper": "threadpoolctl",
    "status out": "pandas",
    "report out": "jinja2",
}
# Hides modules as if they were not installed.
COMMANDS = """
import contextlib, io, json, shlex, sys
from importlib.machinery import PathFinder

hidden = {hidden!r}

class Hiding(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if name.partition(".")[0] not in hidden:
            return super().find_spec(name, path, target)

sys.meta_path[:] = [Hiding if finder is PathFinder else finder for finder in sys.meta_path]
replies = []
for line in {lines!r}:
    sys.argv = ["dubins-study", *shlex.split(line)]
    stderr = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(stderr):
        try:
            from dubins_study.cli.app import main

            main()
        except SystemExit as end:
            replies.append([line, end.code, stderr.getvalue()])
print(json.dumps(replies))
"""


def listed() -> set[str]:
    """Packages of the page's line for planners."""
    [line] = re.findall(r"^pip install ((?!-|'|\.)[\w -]+)$", PAGE.read_text(), flags=re.M)
    return {canonicalize_name(name) for name in line.split()}


def with_their_own(packages: set[str]) -> set[str]:
    """Packages with all those that they require."""
    found: set[str] = set()
    left = set(packages)
    while left:
        name = left.pop()
        found.add(name)
        needed = map(Requirement, requires(name) or ())
        here = [each for each in needed if not each.marker or each.marker.evaluate({"extra": ""})]
        left |= {canonicalize_name(each.name) for each in here} - found
    return found


def replies(packages: set[str], lines: tuple[str, ...], folder: Path) -> list[list[object]]:
    """Reply to each line with some packages alone.

    A reply has command, exit code and stderr; one interpreter answers all lines.
    """
    hidden = {
        module
        for module, owners in packages_distributions().items()
        if not packages & {canonicalize_name(owner) for owner in owners}
    }
    (folder / "points.csv").write_text(POINTS)
    program = COMMANDS.format(hidden=hidden - {"dubins_study"}, lines=lines)
    return json.loads(output(interpreted(program, cwd=folder)).splitlines()[-1])


@pytest.mark.slow
def test_the_list_on_the_page_is_all_that_a_planner_needs(tmp_path):
    """The page's list is all that planners need.

    Legs, routes and tours are solved, proved and written with the packages of the list alone.
    """
    done = replies(with_their_own(listed()), PLANS, tmp_path)

    assert [[line, code] for line, code, _ in done] == [[line, 0] for line in PLANS]


def test_what_needs_another_package_names_it(tmp_path):
    """A missing package is named.

    The exit code is 2 and there is one line, whatever the command; a traceback would be a second
    line.
    """
    done = replies(with_their_own(listed()), tuple(NEED_MORE), tmp_path)

    assert [line for line, _, _ in done] == list(NEED_MORE)
    for line, code, message in done:
        assert code == 2, message
        assert re.fullmatch(
            f"dubins-study: .*the package {NEED_MORE[line]} is not installed; pip install .*\n",
            message,
        )


@pytest.mark.parametrize("package", ["typer", "pydantic", "numpy", "numba", "python-flint"])
def test_a_route_needs_each_of_the_list(package, tmp_path):
    """A route needs each of the list.

    Without one package the command names it, that of the command line itself included.
    """
    assert package in listed()
    [[_, code, message]] = replies(with_their_own(listed()) - {package}, (ROUTE,), tmp_path)

    reason = f"the package {package} is not installed; pip install {package}"
    assert (code, message) == (2, f"dubins-study: {reason}\n")


def test_a_module_of_no_package_that_is_used_is_a_bug():
    """An unknown module is a bug.

    A slip in an import of this package's own is raised, and keeps its traceback.
    """
    with pytest.raises(ModuleNotFoundError, match="no such room"):
        refuse_missing(ModuleNotFoundError("no such room", name="dubins_study.nonsense"))
