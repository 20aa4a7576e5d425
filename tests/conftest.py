"""Fast by default; `--slow` runs the rest as well."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# derandomised, so that a red run can be repeated; no deadline, since the machine may be shared
settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=100,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")

# the tests start hundreds of interpreters, which read the byte code that the first ones keep
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# a suite that was started in the background (`make test &`) inherits that SIGINT is ignored, and
# so would every run that a test interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the slow tests as well")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if "slow" in item.keywords and not config.getoption("--slow"):
            item.add_marker(pytest.mark.skip(reason="slow; run with --slow"))
        if group := _group(item):
            item.add_marker(pytest.mark.xdist_group(group))


def _group(item: pytest.Item) -> str:
    """What stays in one worker where tests run in parallel: tests that look at one shared run."""
    file = item.path.relative_to(Path(__file__).parent)
    if file.parts[0] == "unit" or item.get_closest_marker("xdist_group"):
        return ""
    shared = getattr(item, "callspec", None) and item.callspec.params.get("shared")
    return f"{file.parts[0]} {shared}" if shared else str(file)
