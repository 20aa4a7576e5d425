"""Rooms and the directions of their imports.

`python -m tests.unit.test_layers` prints them.

A room is a folder of the package, or one module where the table names it. Files that lie directly
in a folder with subfolders are a room of their own, below those subfolders: `study/path.py` is in
the room `study`, `study/check/verdict.py` in `study.check`. All imports count, those inside
functions and those for the type checker too.
"""

import ast
import re
import textwrap
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib.metadata import entry_points
from pathlib import Path
from typing import NamedTuple

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "dubins_study"
TESTS = Path(__file__).parents[1]
MOST_MODULES = 14  # in one folder
_LISTS = {"report/topics"}  # folders of modules of one shape, which are read one at a time


class Size(NamedTuple):
    """Syntax nodes and lines of a folder's modules.

    Lines are counted as `wc -l` does.
    """

    nodes: int
    lines: int


# Syntax nodes that a room with all rooms below it, the whole package and the tests may hold. A
# budget is raised only in the commit that adds what it is for.
BUDGETS = {
    "study": 88_100,
    "solvers": 76_600,
    "asking": 5_500,
    "experiments": 38_000,
    "conformance": 11_800,
    "report": 77_500,
    "missions": 8_600,
    "cli": 15_050,
    "package": 321_200,
    "tests": 285_400,
}

_LEAVES = (
    "experiments.interruption",
    "experiments.provenance",
    "experiments.code_digest",
)
_FACTS = ("study", "study.closed_form", "study.rows", "study.route", "study.convex")
# room -> rooms that it may import; `x.*` is the room x and all rooms below it. `errors` is for all.
MAY_IMPORT: dict[str, tuple[str, ...]] = {
    "errors": (),
    "study": (),
    "study.closed_form": ("study",),
    "study.rows": ("study",),
    "study.route": ("study", "study.closed_form"),
    "study.convex": ("study", "study.rows"),
    "study.check": ("study", "study.closed_form", "study.rows", "study.route"),
    "study.tour": ("study", "study.closed_form", "study.route"),
    "study.kinds": (*_FACTS, "study.check", "study.tour"),
    "study.judging": (*_FACTS, "study.check", "study.kinds"),
    "solvers": (*_FACTS, "study.kinds"),  # the closed form asks the kinds; none asks the check
    "solvers.nlp_engines": (*_FACTS, "solvers", "solvers.minlp_engines"),
    "solvers.one_leg": (*_FACTS, "solvers"),
    "solvers.paper_nlp": (*_FACTS, "solvers", "solvers.nlp_engines", "solvers.one_leg"),
    "solvers.optimal_control": (*_FACTS, "solvers", "solvers.nlp_engines", "solvers.one_leg"),
    "solvers.indirect": (*_FACTS, "solvers", "solvers.one_leg"),
    "solvers.minlp_engines": (*_FACTS, "solvers"),
    "solvers.global_minlp": (
        *(*_FACTS, "solvers", "solvers.one_leg", "solvers.paper_nlp"),
        *("solvers.minlp_engines", "solvers.nlp_engines"),
    ),
    "solvers.stochastic": (*_FACTS, "solvers", "solvers.one_leg"),
    "solvers.route": (
        *(*_FACTS, "solvers", "solvers.nlp_engines", "solvers.minlp_engines"),
        "solvers.stochastic",  # its engines search any box
        "solvers.tour",
    ),
    "solvers.tour": (*_FACTS, "solvers", "solvers.minlp_engines"),
    "solvers.convex": (*_FACTS, "solvers"),
    "solvers.export": (
        *(*_FACTS, "solvers", "solvers.one_leg", "solvers.global_minlp"),
        "solvers.nlp_engines",
    ),
    "experiments.isolation.floor": (
        *(*_FACTS, "solvers", "solvers.one_leg", "solvers.paper_nlp", "solvers.convex"),
        *("solvers.minlp_engines", "solvers.stochastic", "solvers.tour"),
    ),
    "asking": ("study.*", "solvers"),
    **dict.fromkeys(_LEAVES, ("study.*", "solvers")),
    "experiments.code_digest": ("study", "solvers", "experiments.provenance"),
    "experiments.definition": ("study.*", "solvers", "asking"),
    "experiments.isolation": (
        "study.*",
        "solvers",
        "asking",
        "experiments.isolation.floor",
        *_LEAVES,
    ),
    "experiments.plan": (
        *("study.*", "solvers", "asking", *_LEAVES),
        *("experiments.definition", "experiments.isolation"),
    ),
    "experiments.store": ("study", "study.rows", *_LEAVES),
    "experiments.executors": (
        *("study.*", "solvers", "asking", *_LEAVES),
        *("experiments.definition", "experiments.isolation", "experiments.plan"),
    ),
    "experiments": ("study.*", "solvers", "solvers.export", "asking", "experiments.*"),
    "conformance": ("study.*", "solvers", "asking", "experiments.isolation"),
    "report.data": ("study.*",),
    "report.statistics": ("study.*", "report.data"),
    "report.paper": ("study.*",),
    "report.elements": ("study.*", "report.data", "report.statistics"),
    "report.topics": (
        *("study.*", "report.data", "report.statistics"),
        *("report.elements", "report.paper"),
    ),
    "report.page": (
        *("study.*", "report.data", "report.statistics"),
        *("report.elements", "report.paper", "report.topics.*"),
    ),
    "report.two_runs": (
        *("study.*", "report.data", "report.statistics"),
        *("report.elements", "report.page"),
    ),
    "report": ("study.*", "report.*"),
    "missions": ("study.*", "asking"),
    "cli.terminal": ("study.*",),
    "cli.solving": ("cli.terminal", "study.*", "solvers", "asking", "missions", "report"),
    "cli": (
        *(
            "cli.terminal",
            "cli.solving",
            "",
            "study.*",
            "solvers.*",
            "asking",
            "experiments.*",
            "report.*",
        ),
        *("conformance", "missions"),
    ),
    "": (
        *("cli", "study.*", "solvers.*", "asking", "experiments.*", "conformance", "report.*"),
        "missions",
    ),
}
# a topic may use another topic's numbers, as long as no circle comes of it
_TOPIC = (*MAY_IMPORT["report.topics"], "report.topics.*")


class Module(NamedTuple):
    """A file of the package.

    It has its dotted name without the package's, its room, and what it imports of the package.
    """

    name: str
    file: Path
    room: str
    imports: frozenset[str]


def _name(file: Path) -> str:
    parts = file.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def room_of(file: Path) -> str:
    """The room that a file lies in.

    It is the module itself where the table names it, else its folder.
    """
    name = _name(file)
    return name if name in MAY_IMPORT else ".".join(file.relative_to(PACKAGE).parent.parts)


def _imports(source: str, names: set[str], file: str = "") -> frozenset[str]:
    """Package modules that a source imports anywhere."""
    imported = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import hides which way it runs"
            deeper = {f"{node.module}.{alias.name}" for alias in node.names}
            submodules = {name for name in deeper if _within(name) in names}
            imported |= submodules
            if submodules != deeper:
                imported.add(str(node.module))
    ours = {name for name in imported if name.split(".")[0] == PACKAGE.name}
    return frozenset(_within(name) for name in ours)


def _within(name: str) -> str:
    """A dotted name without the package's."""
    return name.partition(".")[2] if name.split(".")[0] == PACKAGE.name else f"? {name}"


@cache
def modules() -> dict[str, Module]:
    """All modules of the package by name."""
    files = sorted(PACKAGE.rglob("*.py"))
    names = {_name(file) for file in files}
    by_name = {}
    for file in files:
        imports = _imports(file.read_text(encoding="utf-8"), names, str(file))
        by_name[_name(file)] = Module(_name(file), file, room_of(file), imports - {_name(file)})
    return by_name


@cache
def rooms() -> dict[str, list[Module]]:
    """The modules of each room.

    They come in the table's order; rooms that the table does not know are last.
    """
    by_room: dict[str, list[Module]] = {room: [] for room in MAY_IMPORT}
    for module in modules().values():
        by_room.setdefault(module.room, []).append(module)
    return {room: members for room, members in by_room.items() if members}


def room_imports(room: str) -> set[str]:
    """The other rooms that a room imports."""
    imported = {modules()[name].room for module in rooms()[room] for name in module.imports}
    return imported - {room}


def allowed(room: str) -> tuple[str, ...]:
    """Rooms, or patterns, that a room may import."""
    if room.startswith("report.topics"):
        return _TOPIC
    return MAY_IMPORT[room]


def _covers(pattern: str, room: str) -> bool:
    return room == pattern.removesuffix(".*") or (
        pattern.endswith(".*") and room.startswith(pattern[:-1])
    )


def promise(room: str) -> str:
    """First paragraph of a room's docstring."""
    file = PACKAGE.joinpath(*room.split(".")) if room else PACKAGE
    file = file / "__init__.py" if file.is_dir() else file.with_suffix(".py")
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Names along one circle of a graph.

    None where there is none.
    """
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def sizes() -> dict[str, Size]:
    """Sizes of the rooms of `BUDGETS`."""
    folders = {room: PACKAGE / room for room in BUDGETS} | {"package": PACKAGE, "tests": TESTS}
    return {room: size_of(folder.rglob("*.py")) for room, folder in folders.items()}


def size_of(files: Iterable[Path]) -> Size:
    """The size of some modules together."""
    each = [_size(file) for file in files]
    return Size(sum(size.nodes for size in each), sum(size.lines for size in each))


@cache
def _size(file: Path) -> Size:
    text = file.read_text(encoding="utf-8")
    return Size(sum(1 for _ in ast.walk(ast.parse(text))), text.count("\n"))


@pytest.mark.parametrize("room", BUDGETS)
def test_a_room_keeps_within_its_budget(room):
    nodes = sizes()[room].nodes

    assert nodes <= BUDGETS[room], f"{room}: a maintainer must hold it in the head"


def test_nodes_count_what_is_said_and_not_how_it_is_laid_out(tmp_path):
    """Nodes count statements, not their layout.

    Unfolding a line and explaining it cost nothing; a second assignment does.
    """
    texts = ["a, b = f(1, 2)\n", "# Why.\na, b = f(\n    1,\n    2,\n)\n", "a = f(1)\nb = f(2)\n"]
    files = [tmp_path / f"{number}.py" for number in range(3)]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    folded, unfolded, doubled = map(_size, files)

    assert folded.nodes == unfolded.nodes < doubled.nodes
    assert (folded.lines, unfolded.lines) == (1, 5)
    assert size_of(files).lines == 8


@pytest.mark.parametrize("room", rooms())
def test_a_room_imports_only_what_the_table_lets_it(room):
    """Each import of each module, inside functions too."""
    for module in rooms()[room]:
        for name in sorted(module.imports):
            target = modules()[name].room
            if target in (room, "errors"):
                continue
            assert any(_covers(pattern, target) for pattern in allowed(room)), (
                f"{module.name} imports {name}: the room {room!r} may not import {target!r}"
            )


# rooms that know the answer to a question
ANSWERS = ("study.closed_form", "study.check")


def imports() -> dict[str, set[str]]:
    """Modules that the import of each module imports.

    They are those that it names, and the packages that those lie in.

    The package itself is left out of these: its names are imported when they are first used.
    """
    return {
        module.name: {part for name in module.imports for part in _packages(name)}
        for module in modules().values()
    }


def _packages(name: str) -> Iterator[str]:
    """A module and the packages around it.

    The whole package is left out.
    """
    parts = name.split(".")
    return (".".join(parts[:n]) for n in range(1, len(parts) + 1))


def way_to_the_answers(
    graph: dict[str, set[str]], start: str, rooms: tuple[str, ...] = ANSWERS
) -> list[str]:
    """Shortest way of imports to the rooms.

    It has the modules on the way to a module of the rooms; none without a way.
    """
    before: dict[str, str | None] = {start: None}
    waiting = deque([start])
    while waiting:
        name = waiting.popleft()
        if any(_covers(f"{room}.*", name) for room in rooms):
            way = [name]
            while (importer := before[way[0]]) is not None:
                way.insert(0, importer)
            return way
        for imported in sorted(graph[name] - before.keys()):
            before[imported] = name
            waiting.append(imported)
    return []


# Their formulation, or a guess of theirs, is made of the shortest legs between given headings: the
# closed form of one leg, but no answer to a question with an unknown heading.
OF_LEGS = (
    *("solvers.route.headings", "solvers.route.joint"),
    "solvers.tour.order",
)
# Their costs may also be proven bounds of a leg over two intervals of headings, the same for every
# order: what the search for tours begins with, but no part of what it does with them.
OF_BOUNDS = (
    *("solvers.route.dynamic", "solvers.route.grid", "solvers.tour.milp"),
    *("solvers.tour.circuit", "solvers.tour.routing"),
)
SEARCHES = (
    *("study.route.search", "study.tour", "study.kinds.shortest"),
    *("study.route.descent", "study.route.heading_grids", "study.check"),
)


def solver_modules() -> list[str]:
    """Modules of solvers without answers and legs.

    They belong to the package's registered solvers.
    """
    points = [p for p in entry_points(group="dubins_study.solvers") if _within(p.module)]
    ours = {_within(p.module) for p in points if p.module.split(".")[0] == PACKAGE.name}
    return sorted(ours - {"solvers.analytic", *OF_LEGS, *OF_BOUNDS})


@pytest.mark.parametrize("name", solver_modules())
def test_no_solver_but_the_closed_form_imports_the_answer_or_the_check(name):
    """Only the closed form imports answer or check.

    Other solvers do so neither directly nor by way of other modules of the package.
    """
    assert way_to_the_answers(imports(), name) == []


@pytest.mark.parametrize("name", OF_LEGS)
def test_solvers_of_legs_import_neither_the_search_of_routes_nor_the_check(name):
    assert way_to_the_answers(imports(), name, ("study.route", "study.check")) == []


@pytest.mark.parametrize("name", OF_BOUNDS)
def test_solvers_of_bounds_import_no_search_and_no_check(name):
    assert way_to_the_answers(imports(), name, SEARCHES) == []


@pytest.mark.parametrize(
    ("place", "source"),
    [
        ("study.path", "from dubins_study.study.judging.judge import judge"),
        ("solvers.paper_nlp", "import dubins_study.study.closed_form.shortest as exact"),
        ("solvers.protocol", "def solve():\n    from dubins_study.study.check import verdict"),
        ("solvers.protocol", "from dubins_study import solve"),
    ],
)
def test_an_import_of_the_answer_is_found_wherever_it_is_planted(place, source):
    """A planted import of the answer is found.

    It is planted in a solver's own room or in what it shares with others, inside functions too.
    """
    graph = imports()
    for name in _imports(source, set(modules())):
        graph[place] |= set(_packages(name))

    way = way_to_the_answers(graph, "solvers.paper_nlp.nlp")

    assert way[0] == "solvers.paper_nlp.nlp"
    assert place in way


def test_no_circles_of_modules():
    graph = {module.name: set(module.imports) for module in modules().values()}

    assert circle(graph) == []


def test_no_circles_of_rooms():
    """No circles of rooms exist.

    None is in the imports, and none in the table itself: it lets no room import one that may
    import it.
    """
    graph: dict[str, set[str]] = {room: set() for room in rooms()}
    for module in modules().values():
        for name in module.imports:
            graph[module.room] |= {modules()[name].room} - {module.room}
    # the face is lazy: `cli` imports the public names, `__main__` imports `cli`
    table = {
        room: {r for r in MAY_IMPORT for p in patterns if _covers(p, r)} - {room, ""}
        for room, patterns in MAY_IMPORT.items()
    }

    graph[""].discard("cli")
    assert circle(graph) == []
    assert circle(table) == []


def test_every_room_has_a_line_in_the_table_and_a_promise():
    """A sentence in its `__init__.py`."""
    for room in rooms():
        assert room in MAY_IMPORT or room.startswith("report.topics."), (
            f"{room} is not in the table"
        )
        assert re.fullmatch(r".{10,}\.", promise(room)), f"{room} says no promise"


def test_the_lists_name_rooms_and_modules_that_are_there():
    """The lists name existing rooms and modules.

    Names that are gone would be guarded, or let in, in vain.
    """
    patterns = {pattern for patterns in MAY_IMPORT.values() for pattern in patterns}
    named = {*MAY_IMPORT, *ANSWERS, *OF_LEGS, *OF_BOUNDS, *SEARCHES, *_LEAVES}
    named |= {pattern.removesuffix(".*") for pattern in patterns}
    named |= {folder.replace("/", ".") for folder in _LISTS}
    places = [PACKAGE.joinpath(*name.split(".")) for name in named]

    assert [place for place in places if not (place.is_dir() or _is_module(place))] == []


def _is_module(place: Path) -> bool:
    return place.with_suffix(".py").is_file()


def test_no_folder_has_too_many_modules():
    """`__init__.py`, which says the promise, is not counted."""
    files = [m.file for m in modules().values() if m.file.name != "__init__.py"]
    counts = Counter(file.parent.relative_to(PACKAGE) for file in files)

    full = {str(folder) for folder, n in counts.items() if n > MOST_MODULES}
    assert full <= _LISTS


def test_the_folders_at_the_top_are_links_for_readers():
    """The folders at the top are links for readers.

    Where a checkout has them, nothing is packaged or imported through them.
    """
    root = PACKAGE.parents[1]
    for name in ("study", "solvers", "experiments", "report"):
        link = root / name
        assert not link.exists() or link.resolve() == PACKAGE / name


def table() -> str:
    """Each room with promise, size and imports.

    The budgets follow.
    """
    lines = []
    for room, members in rooms().items():
        size = size_of(module.file for module in members)
        count = sum(1 for m in members if m.file.name != "__init__.py")
        name = room or PACKAGE.name
        lines.append(f"{name:28} {count:3} modules {size.nodes:7} nodes {size.lines:6} lines")
        lines.append(textwrap.indent(textwrap.fill(promise(room), 92), "    "))
        imported = ", ".join(name or PACKAGE.name for name in sorted(room_imports(room)))
        lines.append(textwrap.indent(textwrap.fill(f"imports {imported or 'nothing'}", 92), "    "))
    lines += ["", f"{'budgets':16} {'nodes':>8} {'of':>8} {'lines':>8} {'nodes a line':>14}"]
    for room, size in sizes().items():
        above = "  ABOVE" if size.nodes > BUDGETS[room] else ""
        density = size.nodes / size.lines
        counts = f"{size.nodes:8} {BUDGETS[room]:8} {size.lines:8} {density:14.1f}"
        lines.append(f"{room:16} {counts}{above}")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
