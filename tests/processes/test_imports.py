"""What a fresh interpreter loads: the face and the registry load nothing heavy."""

from __future__ import annotations

import subprocess
import sys

import pytest


def loaded_by(statement: str) -> set[str]:
    """Modules that a fresh interpreter holds after a statement."""
    code = f"import sys; {statement}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_the_registry_imports_no_backend():
    """Names can be listed without loading one backend or its libraries."""
    loaded = loaded_by("from dubins_study.solvers.registry import registered; assert registered()")

    assert not loaded & {"casadi", "cvxpy", "pyomo", "scipy", "numba", "pandas"}
    assert not {m for m in loaded if m.startswith("dubins_study.solvers.")} - {
        "dubins_study.solvers.registry",
        "dubins_study.solvers.protocol",
    }


def test_the_face_is_lazy():
    """Importing the package imports nothing heavy; every public name is there when asked for."""
    assert not loaded_by("import dubins_study.cli.app") & {"numpy", "pandas", "numba", "matplotlib"}
    loaded_by("import dubins_study as d; [getattr(d, name) for name in d.__all__]")


@pytest.mark.slow
def test_a_run_without_streams_loads_no_numba(tmp_path):
    """Rows are judged one at a time; the compiled kernels take half a second to load."""
    loaded = loaded_by(
        f"from dubins_study import run; run('paper', {str(tmp_path / 'out')!r}, solvers=['slsqp'])"
    )

    assert "numba" not in loaded
