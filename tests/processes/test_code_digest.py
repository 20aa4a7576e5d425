"""The digest of a solver's code.

Tested is what changes it, and what does not.
"""

import ast
import shutil
from pathlib import Path

import pytest

from dubins_study.experiments import code_digest as digest_module
from dubins_study.experiments.code_digest import code_digest, solver_sources
from dubins_study.experiments.store.folder import read_rows
from dubins_study.report.data.results import load
from dubins_study.solvers.registry import load as load_solver
from dubins_study.solvers.registry import registered
from tests.live_run import finished, interpreted, manifest, output, quick_experiment

PACKAGE = Path(__file__).parents[2] / "src" / "dubins_study"
ROOMS = {PACKAGE / "solvers", PACKAGE / "study"}
DIGEST = "dubins_study.experiments.code_digest"
PLUGIN = """
from dataclasses import dataclass
from dubins_study.solvers.paper_nlp.nlp import Slsqp

@dataclass(frozen=True)
class Mine(Slsqp):
    patience: float = {patience}
"""


def imported_files(file: Path) -> set[Path]:
    """Imported modules of a module and their packages.

    Imports count anywhere in the module.
    """
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    files = set()
    for name in names:
        place = PACKAGE.parent.joinpath(*name.split("."))
        files |= {place.with_suffix(".py"), place / "__init__.py", place.parent / "__init__.py"}
    return {file for file in files if file.is_file() and ROOMS & {*file.parents}}


@pytest.mark.parametrize("name", registered())
def test_all_modules_that_a_solver_imports_are_read(name):
    """All modules that a solver imports are read.

    They are every module that its module, the check or another of these imports, inside functions
    too.
    """
    solver_class = type(load_solver(name))
    module = PACKAGE.parent.joinpath(*solver_class.__module__.split(".")).with_suffix(".py")
    judges = ("study/check/verdict.py", "study/judging/certify.py")
    judges += ("study/tolerances.py", "asking/attempt.py")
    wanted: set[Path] = set()
    left = {module, *(PACKAGE / judge for judge in judges)}
    while left:
        wanted |= left
        left = set().union(*map(imported_files, left)) - wanted
    files = {file.relative_to(PACKAGE).as_posix() for file in wanted}
    # the columns of the results format decide no value; a change of theirs has a new schema version
    files = {name for name in files if not name.startswith("study/rows/")}

    assert len(files) > 10
    assert files - {"solvers/__init__.py"} <= solver_sources(name, solver_class).keys()


@pytest.mark.slow
def test_an_edit_changes_the_digest_of_the_room_and_of_rooms_that_build_on_it(tmp_path):
    """An edit changes the digests that build on it.

    Edited are the solver's room and the check in a copy of the package; another room changes
    nothing.
    """
    shutil.copytree(PACKAGE, tmp_path / "dubins_study")
    names = ("slsqp", "ipopt", "shooting", "turn-rate-qp", "analytic")

    def stale_after(file: str, added: str = "EDITED = 1") -> set[str]:
        edited = tmp_path / "dubins_study" / file
        text = edited.read_text(encoding="utf-8")
        edited.write_text(f"{text}{added}\n", encoding="utf-8")
        after = digests()
        edited.write_text(text, encoding="utf-8")
        return {name for name in names if after[name] != before[name]}

    def digests() -> dict[str, str]:
        lines = [f"print(code_digest({name!r}))" for name in names]
        return dict(zip(names, printed(*lines, path=tmp_path), strict=True))

    before = digests()
    assert stale_after("solvers/optimal_control/turn_rate_qp.py") == {"turn-rate-qp"}
    assert stale_after("solvers/paper_nlp/pyomo_model.py") >= {"slsqp", "ipopt"}
    assert stale_after("solvers/paper_nlp/pyomo_model.py").isdisjoint({"analytic"})
    assert stale_after("solvers/one_leg/model.py") >= {"slsqp", "ipopt", "shooting"}
    assert stale_after("solvers/analytic.py") == {"analytic"}
    assert stale_after("study/check/verdict.py") == set(names)
    assert stale_after("study/check/verdict.py", "# edited") == set()
    assert stale_after("study/rows/schema.py") == set()


def test_every_solver_has_a_code_of_its_own():
    digests = {name: code_digest(name) for name in registered()}

    assert len(set(digests.values())) == len(digests)
    assert all(len(digest) == 12 and int(digest, 16) >= 0 for digest in digests.values())


def test_settings_make_a_code_of_their_own():
    """Settings make a code of their own.

    They come from the spec or from the profile.
    """
    assert code_digest("slsqp[count=3]") != code_digest("slsqp")
    assert code_digest(" slsqp[ model=words ]") == code_digest("slsqp")
    assert code_digest("slsqp", "accurate") != code_digest("slsqp", "default")


def printed(*lines: str, path: Path | None = None) -> list[str]:
    """Output of a new process.

    It remembers no digest.
    """
    text = "\n".join((f"from {DIGEST} import code_digest", *lines))
    return output(interpreted(text, **({"PYTHONPATH": str(path)} if path else {}))).split()


RELAID = """
# A comment.
from dataclasses import dataclass

from dubins_study.solvers.paper_nlp.nlp import (
    Slsqp,
)


@dataclass(
    frozen=True
)
class Mine(Slsqp):
    '''A docstring that names dubins_study.solvers.optimal_control.'''

    patience: "float" = 1  # seconds
    '''How long it waits.'''
"""


@pytest.mark.many(2)
@pytest.mark.parametrize(
    ("text", "same"),
    [
        (RELAID, True),
        (RELAID.replace("\n", "\r\n"), True),
        (RELAID.replace("= 1", "= 2"), False),
        (RELAID.replace("= 1", "= 1.0"), False),
        (RELAID.replace("patience", "zeal"), False),
        (RELAID.replace("Mine(Slsqp)", "Mine(Slsqp, object)"), False),
    ],
)
def test_a_plugin_is_told_by_its_syntax(text, same, tmp_path):
    """A plug-in is told by its syntax.

    A comment, a docstring and another layout leave the digest; a constant changes it.
    """
    plugin = tmp_path / "mine.py"
    digests = []
    for content in (PLUGIN.format(patience=1).replace("float", '"float"'), text):
        plugin.write_bytes(content.encode())
        digests += printed(f"print(code_digest({f'{plugin}:Mine'!r}))")

    assert (digests[0] == digests[1]) is same


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("x = None", "x: y"),
        ("f(a, b)", "f(a)(b)"),
        ("x = 'y'", "x = y"),
        ("def f():\n    'text'\n    return 1", "def f():\n    x = 'text'\n    return 1"),
        ("{None: 1}", "{**a}"),
        ("x = a - (b - c)", "x = a - b - c"),
        ("from a import b", "from a import c"),
        ("[(yield), (yield x)]", "[(yield x), (yield)]"),
        ("[a[:b], a[c:]]", "[a[b:], a[:c]]"),
        ("no Python", "no python"),
    ],
)
def test_what_differs_has_another_syntax(one, other, tmp_path):
    """Different code has different syntax.

    A file that is no Python is compared by its bytes.
    """
    files = tmp_path / "one.py", tmp_path / "other.py"
    for file, text in zip(files, (one, other), strict=True):
        file.write_text(text)

    assert digest_module._read(files[0]) != digest_module._read(files[1])


def test_syntax_is_python_without_docstrings_and_with_whole_names(tmp_path):
    file = tmp_path / "some.py"
    file.write_text("def f(x):\n    'Text.'\n    from a.b import c, d as e\n    return ( x+1 )")

    text = "def f(x):\n    import a.b.c, a.b.d as e\n    return x + 1"
    assert digest_module._read(file).decode() == text


def test_the_judge_of_all_solvers_is_there():
    assert digest_module._room(digest_module._JUDGE)


def test_other_libraries_make_another_code(monkeypatch):
    code_digest.cache_clear()
    before = code_digest("slsqp")
    code_digest.cache_clear()
    monkeypatch.setattr(digest_module, "versions_of", lambda packages: dict.fromkeys(packages, "0"))
    try:
        assert code_digest("slsqp") != before
        assert code_digest("analytic")  # which names no package
    finally:
        code_digest.cache_clear()


@pytest.mark.slow
def test_rows_of_earlier_code_are_solved_anew_and_never_shown(tmp_path):
    """Rows of earlier code are solved anew, never shown.

    They are kept, counted, and left out of everything else.
    """
    spec = f"{tmp_path}/mine.py:Mine"
    out = tmp_path / "out"
    file = quick_experiment(tmp_path, 2, f'{spec}", "analytic')
    for patience in (1, 2):
        (tmp_path / "mine.py").write_text(PLUGIN.format(patience=patience))
        done = output(finished("run", file, "--trust-plugins", "--out", out))
        assert "4 of 4 cells done, finished" in done

    table = read_rows(out, ["run_id"]).to_pandas()
    assert table.groupby("solver")["code_digest"].nunique().to_dict() == {spec: 2, "analytic": 1}
    assert table.groupby("solver").size().to_dict() == {spec: 4, "analytic": 2}
    assert "2 rows of earlier code" in output(finished("status", out))
    shown = load([out])
    assert len(shown.rows) == 4
    newest = manifest(out)["solvers"][spec]
    assert set(shown.rows["code_digest"]) == {newest["code_digest"], code_digest("analytic")}
    assert newest["settings"]["patience"] == 2
    assert newest["cells"] == 2
    assert shown.folders[0].rows.stale == 2
    output(finished("report", out))
    assert "2 rows of earlier code of their solvers" in (out / "report/index.html").read_text()
