"""Imports run one way: study, solvers, experiments, report, dubins_study."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MAY_IMPORT = {
    "study": {"study"},
    "solvers": {"study", "solvers"},
    "experiments": {"study", "solvers", "experiments"},
    "report": {"study", "report"},
    "dubins_study": {"study", "solvers", "experiments", "report", "dubins_study"},
}


def imports(file: Path) -> set[str]:
    """Top-level names of everything that a file imports, inside functions too."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative imports hide which way they run"
            found.add(str(node.module).split(".")[0])
    return found


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_imports_run_one_way(package):
    """No package imports one that comes after it."""
    files = sorted((ROOT / package).rglob("*.py"))
    assert files

    for file in files:
        backwards = (imports(file) & MAY_IMPORT.keys()) - MAY_IMPORT[package]
        assert not backwards, f"{file.relative_to(ROOT)} imports {backwards}"


def loaded_by(statement: str) -> set[str]:
    """Modules that a fresh interpreter holds after a statement."""
    code = f"import sys; {statement}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_the_registry_imports_no_backend():
    """Names can be listed without loading one backend or its libraries."""
    loaded = loaded_by("from dubins_study.solvers.registry import registered; assert registered()")

    assert not loaded & {"casadi", "cvxpy", "pyomo", "scipy", "numba", "pandas"}
    assert not {m for m in loaded if m.startswith("solvers.")} - {
        "dubins_study.solvers.registry",
        "dubins_study.solvers.protocol",
    }


def test_the_face_is_lazy():
    """Importing the package imports nothing heavy; every public name is there when asked for."""
    assert not loaded_by("import dubins_study.cli.app") & {"numpy", "pandas", "numba", "matplotlib"}
    loaded_by("import dubins_study as d; [getattr(d, name) for name in d.__all__]")
