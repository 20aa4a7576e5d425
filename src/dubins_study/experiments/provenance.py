"""Where a run came from: versions, machine, state of the source."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path as FilePath

import psutil

from dubins_study.solvers.protocol import Solver

THREAD_VARIABLES = tuple(f"{name}_NUM_THREADS" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA"))
# what every row rests on, whatever its solver
_ALWAYS = ("dubins-study", "numpy", "pandas", "pyarrow", "numba")


def now() -> str:
    """This moment in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


@cache
def versions(packages: tuple[str, ...] = ()) -> dict[str, str]:
    """Versions of Python, of what every row rests on, and of the packages named."""
    return {"python": platform.python_version()} | versions_of((*_ALWAYS, *packages))


@cache
def versions_of(packages: tuple[str, ...]) -> dict[str, str]:
    """Versions of distributions."""
    found = {}
    for package in packages:
        try:
            found[package] = version(package)
        except (PackageNotFoundError, ValueError):
            found[package] = "not installed"
    return found


def solver_versions(solver: Solver) -> dict[str, str]:
    """Versions that a row of this solver rests on, asked where it is solved.

    Of Python, of what every row rests on, of the solver's packages, and of the libraries inside
    them whose own versions the solver knows at run time.
    """
    return versions(tuple(solver.packages)) | _library_versions(solver)


def _library_versions(solver: Solver) -> dict[str, str]:
    try:
        return {str(name): str(found) for name, found in dict(solver.library_versions()).items()}
    except Exception as error:  # a plug-in may fail in any way
        return {"library_versions": f"raised {type(error).__name__}"}


@cache
def machine() -> dict[str, str | int]:
    """What kind of machine this is; its name and its paths are nobody's business."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
        "usable_cores": _usable_cores(),
        "memory": f"{psutil.virtual_memory().total / 2**30:.1f} GiB",
        "python": platform.python_version(),
    }


def _usable_cores() -> int:
    """How many cores this process may run on."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # there is no affinity on this system
        return os.cpu_count() or 1


@cache
def host() -> str:
    """The machine in one line."""
    kind = machine()
    return f"{kind['system']}, {kind['processor']}, {kind['cores']} cores"


def governor(cpus: FilePath = FilePath("/sys/devices/system/cpu")) -> str:
    """What sets the cores' clock: performance, powersave, ...; all of them if they differ."""
    found = set()
    for file in cpus.glob("cpu[0-9]*/cpufreq/scaling_governor"):
        try:
            found.add(file.read_text(encoding="utf-8").strip())
        except (OSError, UnicodeDecodeError):
            continue
    return ", ".join(sorted(found)) or "unknown"


def load_average() -> list[float] | None:
    """How many processes wanted a core over the last 1, 5 and 15 minutes, if that is known."""
    try:
        return [round(value, 2) for value in os.getloadavg()]
    except (OSError, AttributeError):
        return None


def thread_limits() -> dict[str, str]:
    """The variables of the environment that bound numerical libraries' threads, where set."""
    return {name: value for name in THREAD_VARIABLES if (value := os.environ.get(name))}


def _processor() -> str:
    try:
        lines = FilePath("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown"


@cache
def source() -> dict[str, str | bool]:
    """Commit of the source tree and whether it was changed since; empty outside a checkout."""
    root = FilePath(__file__).parents[3]
    if not (root / ".git").exists():
        return {}
    commit = _git(root, "rev-parse", "HEAD")
    if commit is None:
        return {}
    return {"commit": commit, "changed": bool(_git(root, "status", "--porcelain"))}


def _git(root: FilePath, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=10
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
