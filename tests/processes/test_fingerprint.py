"""The digest of a solver's code: what changes it, and what does not."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.plan import code_digest as fingerprint
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.plan.code_digest import code
from dubins_study.experiments.store.folder import read_rows
from dubins_study.report.data.results import load
from dubins_study.solvers.registry import SolverError, registered

ROOT = Path(__file__).parents[2]
PLUGIN = """
from dataclasses import dataclass
from dubins_study.solvers.paper_nlp.slsqp import Slsqp

@dataclass(frozen=True)
class Mine(Slsqp):
    patience: float = {patience}
    # {remark}
"""


def read_imports(module: str) -> set[str]:
    """Modules of ours that a module imports, by another way: whole, and with the files' names."""
    place = ROOT / module.replace(".", "/")
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    names = {".".join(f.relative_to(ROOT).with_suffix("").parts) for f in ROOT.glob("s*/*.py")}
    return found & {name for name in names if name.startswith(("study.", "solvers."))}


@pytest.mark.parametrize("name", registered())
def test_all_modules_that_a_solver_imports_are_read(name):
    """The quick reading misses no import, lazy ones included."""
    kind = type(fingerprint.load(name))
    wanted, left = (
        set(),
        {
            kind.__module__,
            "dubins_study.study.check.verdict",
            "dubins_study.study.check.certificate",
        },
    )
    left |= {"dubins_study.solvers.profiles", "dubins_study.solvers.attempt"}
    while left:
        wanted |= left
        left = set().union(*map(read_imports, left)) - wanted

    assert wanted == fingerprint._sources(name, kind).keys() - {"study", "solvers"}


def test_every_solver_has_a_code_of_its_own():
    found = {name: code(name) for name in registered()}

    assert len(set(found.values())) == len(found)
    assert all(len(digest) == 12 and int(digest, 16) >= 0 for digest in found.values())


def test_settings_make_a_code_of_their_own():
    """However they came about: by the spec or by the profile."""
    assert code("slsqp[count=3]") != code("slsqp")
    assert code(" slsqp[ model=words ]") == code("slsqp")
    assert code("slsqp", "accurate") != code("slsqp", "default")


def test_a_solver_that_does_not_exist_is_refused_as_everywhere():
    with pytest.raises(SolverError, match="no solver named 'anal'"):
        code("anal")


def codes(*lines: str) -> list[str]:
    """What a fresh process prints: nothing of it is kept from the last one."""
    text = "\n".join(("from dubins_study.experiments.plan.code_digest import code", *lines))
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_a_plugin_is_told_by_its_text_and_its_defaults(tmp_path):
    plugin = tmp_path / "mine.py"
    spec = f"{plugin}:Mine"
    found = []
    for patience, remark in ((1, ""), (2, ""), (2, "new"), (1, "")):
        plugin.write_text(PLUGIN.format(patience=patience, remark=remark))
        found += codes(f"print(code({spec!r}))")

    assert found[0] == found[3]
    assert len(set(found)) == 3


def test_other_libraries_make_another_code(monkeypatch):
    fingerprint.code.cache_clear()
    before = code("slsqp")
    fingerprint.code.cache_clear()
    monkeypatch.setattr(fingerprint, "versions_of", lambda packages: dict.fromkeys(packages, "0"))
    try:
        assert code("slsqp") != before
        assert code("analytic")  # which names no package
    finally:
        fingerprint.code.cache_clear()


EXPERIMENT = """
title = "changing"
question = "what is stale?"
solvers = ["{spec}", "analytic"]
[[scenarios]]
target_x = [1, 2]
target_y = 3
"""


def test_rows_of_earlier_code_are_solved_anew_and_never_shown(tmp_path):
    """They are kept, counted, and left out of everything else."""
    plugin, file = tmp_path / "mine.py", tmp_path / "changing.toml"
    file.write_text(EXPERIMENT.format(spec=f"{plugin}:Mine"))
    out = tmp_path / "out"
    for patience in (1, 2):
        plugin.write_text(PLUGIN.format(patience=patience, remark=""))
        done = dubins_study("run", str(file), "--trust-plugins", "--out", str(out))
        assert "4 of 4 cells done, finished" in done

    kept = read_rows(out, ["run_id"]).to_pandas()
    assert kept.groupby("solver")["code_digest"].nunique().to_dict() == {
        f"{plugin}:Mine": 2,
        "analytic": 1,
    }
    assert kept.groupby("solver").size().to_dict() == {f"{plugin}:Mine": 4, "analytic": 2}
    assert "2 rows of earlier code" in dubins_study("status", str(out))
    shown = load([out])
    assert len(shown.rows) == 4
    newest = json.loads((out / "manifest.json").read_text())["solvers"][f"{plugin}:Mine"]
    assert set(shown.rows["code_digest"]) == {newest["code_digest"], code("analytic")}
    assert newest["settings"]["patience"] == 2
    assert newest["cells"] == 2
    assert shown.folders[0].rows.stale == 2
    dubins_study("report", str(out))
    for page in ("index.html", "report.md"):
        assert "2 rows of earlier code of their solvers" in (out / "report" / page).read_text()


def dubins_study(*arguments: str) -> str:
    command = [sys.executable, "-m", "dubins_study", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout


def test_cells_know_their_code(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(EXPERIMENT.format(spec="slsqp"))
    cells = [cell for chain in chains(read(str(file)).experiment) for cell in chain]

    assert {cell.code_digest for cell in cells} == {code("slsqp"), code("analytic")}
    assert {cell.key[-1] for cell in cells} == {cell.code_digest for cell in cells}


def test_folders_of_two_codes(tmp_path):
    """Of a cell that both hold the first is kept, and the page says what was left out."""
    plugin, file = tmp_path / "mine.py", tmp_path / "changing.toml"
    file.write_text(EXPERIMENT.format(spec=f"{plugin}:Mine"))
    for patience in (1, 2):
        plugin.write_text(PLUGIN.format(patience=patience, remark=""))
        dubins_study("run", str(file), "--trust-plugins", "--out", str(tmp_path / str(patience)))
    one, two = tmp_path / "1", tmp_path / "2"

    found = load([one, two])

    assert len(found.rows) == 4
    assert [folder.rows.replaced for folder in found.folders] == [0, 2]
    dubins_study("report", str(one), str(two), "--out", str(tmp_path / "page"))
    said = "2 rows of cells that a folder before this one holds, made by other code"
    assert said in (tmp_path / "page" / "index.html").read_text()
    assert set(read_rows(one)["code_digest"].to_pylist()) != set(
        read_rows(two)["code_digest"].to_pylist()
    )


def test_folders_that_contradict_each_other(tmp_path):
    """The same code that found two things: the page says so first, however many folders do."""
    plugin, file = tmp_path / "mine.py", tmp_path / "chance.toml"
    plugin.write_text(
        "import os\nfrom dubins_study.solvers.paper_nlp.slsqp import Slsqp\nclass Mine(Slsqp):\n"
        "    def solve(self, model, limit):\n"
        "        if os.environ.get('FAIL') and model.question.scenario.target_x == 2:\n"
        "            raise ValueError('bad luck')\n"
        "        return super().solve(model, limit)\n"
    )
    file.write_text(EXPERIMENT.format(spec=f"{plugin}:Mine"))
    folders = [tmp_path / name for name in ("one", "two", "three")]
    for folder, fail in zip(folders, ("", "yes", "yes"), strict=True):
        asked = ["run", str(file), "--trust-plugins", "--out", str(folder)]
        command = [sys.executable, "-m", "dubins_study", *asked]
        subprocess.run(command, check=True, env={**os.environ, "FAIL": fail}, capture_output=True)

    found = load(folders)

    assert len(found.rows) == 4
    assert "raised" not in set(found.rows["outcome"])
    assert [folder.rows.contradicting for folder in found.folders] == [0, 1, 1]
    assert load(folders[1:]).folders[1].rows.contradicting == 0
    dubins_study("report", *map(str, folders), "--out", str(tmp_path / "page"))
    for page in ("index.html", "report.md"):
        text = (tmp_path / "page" / page).read_text()
        assert text.count("It contradicts a folder before it in 1 cell, by the same code") == 2


def test_what_lies_beside_a_plugin_file_counts(tmp_path):
    """As it would be imported if the plug-in puts its own folder on the path."""
    (tmp_path / "beside.py").write_text("SCALE = 1.0\n")
    (tmp_path / "mine.py").write_text(
        "import sys\nfrom pathlib import Path\nsys.path.insert(0, str(Path(__file__).parent))\n"
        "import beside\nfrom dubins_study.solvers.paper_nlp.slsqp import Slsqp\nclass Mine(Slsqp):\n    pass\n"
    )
    spec = f"{tmp_path}/mine.py:Mine"
    command = f"from dubins_study.experiments.plan.code_digest import code; print(code({spec!r}))"

    def digest():
        return subprocess.run(
            [sys.executable, "-c", command], capture_output=True, text=True, check=True
        ).stdout

    before = digest()
    assert digest() == before
    (tmp_path / "beside.py").write_text("SCALE = 2.0\n")
    assert digest() != before
