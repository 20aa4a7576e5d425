"""Where a run came from: versions, machine, state of the source."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path as FilePath

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


@cache
def machine() -> dict[str, str | int]:
    """What kind of machine this is; its name and its paths are nobody's business."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
    }


def host() -> str:
    """The machine in one line."""
    kind = machine()
    return f"{kind['system']}, {kind['processor']}, {kind['cores']} cores"


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
    root = FilePath(__file__).parent.parent
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
