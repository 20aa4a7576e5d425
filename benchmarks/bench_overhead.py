"""Cost of a cell beyond its solver.

Our harness stands beside benchopt and qpbenchmark.

Each harness runs the same trivial solver over the same number of cells, with one job. The solver
is `benchmarks/overhead/trivial.py`, some ten microseconds of closed form. A harness runs as its own
command line would: with a fresh folder, no cache, no plots. Ours does the same as for any solver: a
watched worker process, the check, the certificate, a row of some seventy columns, Parquet every
second.

    overhead of a cell = (W(N2) - W(N1)) / (N2 - N1),  W = seconds of the run - the solver's own

Costs that are paid once (imports, folders, the start of a worker) cancel out of the difference of
two sizes; the note has the whole run all the same. Every run is a process of its own, the
harnesses take turns, and the least of the rounds counts for each size. The solver's own seconds are
those that the harness itself writes into its results.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable
from importlib.util import find_spec
from itertools import product
from tempfile import TemporaryDirectory

from benchmarks.harness import Measurement, absent, sized
from benchmarks.overhead.harnesses import HARNESSES, Spent

FEW = sized(200, 2)
MANY = sized(1200, 5)
ROUNDS = sized(3, 1)
LONG = (
    sized(2000, 2),
    sized(8000, 5),
)  # cells that ours alone is run over too: peers would take minutes
TARGET = 300.0  # microseconds
_EXTRA = "is not installed: pip install 'dubins-study[harnesses]'"
PEERS = ("benchopt", "qpbenchmark")


def measure() -> Iterable[Measurement]:
    present = [name for name in HARNESSES if name not in PEERS or find_spec(name)]
    runs = _runs(present, (FEW, MANY))
    cell = {name: _overhead(runs, name, FEW, MANY) for name in present}
    ours = cell["ours"]
    note = f"beside what is aimed at; {_whole(runs, 'ours')}"
    yield _beside("our harness: a cell's overhead beyond its solver", ours, TARGET, note)
    steady = _overhead(_runs(["ours"], LONG), "ours", *LONG)
    note = f"from {LONG[0]} to {LONG[1]} cells, parts and manifests written on the way"
    yield _beside("the same in a long run", steady, TARGET, note)
    alone = cell["in process"]
    yield Measurement(
        "the same, judged but not isolated",
        ours=ours,
        peer=alone,
        unit="µs/cell",
        ratio=ours / alone,
        note=f"a watched process of its own costs {ours - alone:.0f} µs a cell",
    )
    for name in PEERS:
        what = f"our harness beside {name}"
        if name not in cell:
            yield absent(what, f"{name} {_EXTRA}")
            continue
        yield _beside(what, ours, cell[name], _whole(runs, name))


def _beside(what: str, ours: float, peer: float, note: str) -> Measurement:
    """Microseconds a cell and their target.

    The target is a peer's time or a fixed aim.
    """
    ratio = ours / peer
    return Measurement(
        what, ours=ours, peer=peer, unit="µs/cell", ratio=ratio, target=1.0, note=note
    )


def _runs(names: list[str], sizes: tuple[int, int]) -> dict[tuple[str, int], list[Spent]]:
    """Every harness at both sizes, in turn."""
    runs: dict[tuple[str, int], list[Spent]] = {key: [] for key in product(names, sizes)}
    for _ in range(ROUNDS):
        for (name, cells), spent in runs.items():
            spent.append(_spent(name, cells))
    return runs


def _spent(name: str, cells: int) -> Spent:
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "benchmarks.overhead.harnesses", name, str(cells), folder]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{name} with {cells} cells: {done.stderr.strip().splitlines()[-1]}")
    return Spent(*map(float, done.stdout.split()[-2:]))


def _least(spent: list[Spent]) -> float:
    return min(run.whole - run.solver for run in spent)


def _overhead(runs: dict[tuple[str, int], list[Spent]], name: str, few: int, many: int) -> float:
    """Microseconds a cell."""
    return (_least(runs[name, many]) - _least(runs[name, few])) / (many - few) * 1e6


def _whole(runs: dict[tuple[str, int], list[Spent]], name: str) -> str:
    whole = min(run.whole for run in runs[name, MANY])
    solver_s = min(run.solver for run in runs[name, MANY])
    return f"{MANY} cells in {whole:.2f} s, {solver_s * 1e3:.0f} ms of them the solver's"
