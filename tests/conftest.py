"""Two minutes of tests; `--slow` runs the rest."""

import os
import re
import signal
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

# derandomised, so that a red run can be repeated; no deadline, since the machine may be shared
settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=100,
    suppress_health_check=[HealthCheck.too_slow],
)
# the tests that are not slow draw fewer of the same kind; continuous integration runs all tests
settings.register_profile("quick", settings.get_profile("repeatable"), max_examples=20)
# other examples: hypothesis would ignore `--hypothesis-seed` where it is derandomised
settings.register_profile("seeded", settings.get_profile("repeatable"), derandomize=False)
settings.load_profile("quick")

# Hypothesis also draws the constants of all modules that are loaded by then, and so would draw
# other examples in each worker and each order of tests.
_NO_CONSTANTS = providers.Constants()
providers._get_local_constants = lambda: _NO_CONSTANTS

# the tests start hundreds of interpreters, which read the byte code that the first ones keep
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# a suite that was started in the background (`make test &`) inherits that SIGINT is ignored, and
# so would every run that a test interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the slow tests as well")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("hypothesis_seed", None) is not None:
        settings.load_profile("seeded")
    elif config.getoption("--slow"):
        settings.load_profile("repeatable")


# Of these a run without `--slow` asks only what is marked `smoke`, and not `slow` as well.
SLOW_PLACES = (
    "tests/adversary",
    "tests/browser",
    "tests/docs/test_snippets.py",
    "tests/faults",
    "tests/fuzz",
    "tests/processes",
)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--slow"):
        return
    many: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        in_slow_place = item.nodeid.startswith(SLOW_PLACES) and "smoke" not in item.keywords
        if in_slow_place or "slow" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="slow; run with --slow"))
        elif "many" in item.keywords:
            many[item.nodeid.partition("[")[0]].append(item)
    for alike in many.values():
        (few,) = alike[0].get_closest_marker("many").args
        places = {round(place * len(alike) / few) for place in range(few)}
        for place, item in enumerate(alike):
            if place not in places:
                item.add_marker(pytest.mark.skip(reason="one of many; run with --slow"))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Group tests by their names.

    The mark of pytest-xdist 3.8 is lost under pytest 9.2.
    """
    if config.getoption("dist") != "loadgroup":
        return None
    from xdist.scheduler import LoadScopeScheduling

    class Groups(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return _group(nodeid)

    return Groups(config, log)


_BY_FOLDER = ("tests/browser",)  # one browser and one report for all of them
_RUN = re.compile(r"\w+, \d jobs")  # how a parameter names the run that many tests look at
_ALONE = ("tests/adversary",)  # one file of long tests that share nothing


def _group(nodeid: str) -> str:
    """Name of the tests that stay in one worker.

    They are the tests of one shared run, else of one file, or one test.
    """
    file, _, test = nodeid.partition("::")
    if file.startswith(_ALONE):
        return nodeid
    if file.startswith(_BY_FOLDER):
        return str(Path(file).parent)
    run = _RUN.search(test)
    return f"{Path(file).parent} {run[0]}" if run else file
