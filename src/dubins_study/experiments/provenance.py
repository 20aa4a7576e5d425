"""Origin of a run: versions, machine and source."""

from __future__ import annotations

import os
import platform
import subprocess
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path as FilePath

import psutil

# Packages that every row depends on, with any solver.
_BASE_PACKAGES = ("dubins-study", "numpy", "pandas", "pyarrow", "numba")


def now() -> str:
    """This moment in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


@cache
def versions(packages: tuple[str, ...] = ()) -> dict[str, str]:
    """Versions of Python and of packages.

    Packages on which every row depends are included.
    """
    return {"python": platform.python_version()} | versions_of((*_BASE_PACKAGES, *packages))


@cache
def versions_of(packages: tuple[str, ...]) -> dict[str, str]:
    """Versions of packages, by name.

    `not installed` stands for a package that is missing.
    """
    return {package: _version(package) for package in packages}


def _version(package: str) -> str:
    try:
        return version(package)
    except (PackageNotFoundError, ValueError):
        return "not installed"


@cache
def machine() -> dict[str, str | int]:
    """The kind of this machine.

    The machine's name and paths are private and left out.
    """
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
    except AttributeError:  # this system cannot bind a process to cores
        return os.cpu_count() or 1


@cache
def host() -> str:
    """The machine in one line."""
    kind = machine()
    return f"{kind['system']}, {kind['processor']}, {kind['cores']} cores"


def governor(cpus: FilePath = FilePath("/sys/devices/system/cpu")) -> str:
    """The policy that sets the cores' clock.

    An example is `performance`. Several are listed if cores differ.
    """
    governors = set()
    for file in cpus.glob("cpu[0-9]*/cpufreq/scaling_governor"):
        with suppress(OSError, UnicodeDecodeError):
            governors.add(file.read_text(encoding="utf-8").strip())
    return ", ".join(sorted(governors)) or "unknown"


def load_average() -> list[float]:
    """Mean numbers of processes that wanted a core.

    The list has the means over the last 1, 5 and 15 minutes.
    """
    return [round(value, 2) for value in psutil.getloadavg()]


def _processor() -> str:
    try:
        lines = FilePath("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    for line in lines:
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown"


@cache
def source() -> dict[str, str | bool]:
    """The commit of the source tree.

    `changed` tells whether files were changed since. Empty without git.
    """
    root = FilePath(__file__).parents[3]
    if not (root / ".git").exists():
        return {}
    commit = _git(root, "rev-parse", "HEAD")
    if commit is None:
        return {}
    return {"commit": commit, "changed": bool(_git(root, "status", "--porcelain"))}


def _git(root: FilePath, *arguments: str) -> str | None:
    try:
        process = subprocess.run(
            ["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=10
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    if process.returncode != 0:
        return None
    return process.stdout.strip()
