"""Attack the package with hard cases: `python -m tests.adversary.campaign 1000000`.

Prints a table of what was tried and the first counterexample of each check as a line to paste
(`from dubins_study import Scenario as S`, `Path`; `enclose`, `judge` and the others from the room
`dubins_study.study`); exits with 1 if there is one.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from time import perf_counter

import numpy as np
from flint import ctx

from dubins_study.study.path import drivable
from dubins_study.study.scenario import Scenario
from tests.adversary import answers, checks, frames
from tests.adversary.generators import Answer, case, wrong_answer
from tests.adversary.oracle import bits, end
from tests.adversary.table import Table
from tests.adversary.truth import Truth

BLOCK = 500  # cases; what a frame holds, and what a worker does before it reports
_SHOWN = 10  # counterexamples of a check, after which the next are only counted
_SELF_CHECKED = 50  # one case in so many is sampled densely, and used against the oracle itself


def run(seed: int, low: int, high: int) -> Table:
    """The cases `low` to `high` - 1 of a seed."""
    table = Table()
    numbers = range(low, high)
    cases = [case(seed, number) for number in numbers]
    altered: list[frames.Judged] = []
    sampled: list[frames.Hulls] = []
    for number, (kind, scenario) in zip(numbers, cases, strict=True):
        table.generator = kind
        rng = np.random.default_rng((seed, number, 1))
        # by lot: generators take turns with the number
        self_checked = rng.random() * _SELF_CHECKED < 1
        sampled.append(_one(table, scenario, rng, self_checked))
        altered.append(_answer(table, scenario, rng))
    frames.closed_forms(table, cases)
    frames.judgements(table, cases, sampled)
    frames.wrong_answers(table, altered)
    return table


def _one(
    table: Table, scenario: Scenario, rng: np.random.Generator, self_checked: bool
) -> frames.Hulls:
    """One case; the least and the greatest of its sampled lengths by branch."""
    with ctx.workprec(bits(scenario)):
        truth = Truth.of(scenario)
        checks.closed_form(table, scenario, truth, rng)
        sampled = checks.enclosures(table, scenario, truth)
        checks.bounds(table, scenario, truth)
        if self_checked:
            checks.dense(table, scenario, truth, rng)
            checks.oracle(table, scenario, truth, rng)
    return sampled


def _answer(table: Table, scenario: Scenario, rng: np.random.Generator) -> frames.Judged:
    """An altered answer to the scenario, or to one of its own, judged."""
    kind, asked = _allowed(rng, scenario)
    scenario, branch, path = asked
    table.generator = kind.replace("_", " ")
    with ctx.workprec(bits(scenario)):
        truth = Truth.of(scenario)
        driven = end(scenario, path) if drivable(path) else None
        judged, certificate = answers.answer(table, scenario, branch, path, truth, driven, rng)
    return frames.Judged(table.generator, asked, judged, certificate)


def _allowed(rng: np.random.Generator, scenario: Scenario) -> tuple[str, Answer]:
    while True:
        try:
            return wrong_answer(rng, scenario)
        except ValueError:  # the altered path ends where no scenario's target may lie
            continue


def campaign(cases: int, seed: int, workers: int) -> Table:
    """All cases in blocks, by several processes."""
    table, began = Table(), perf_counter()
    lows = range(0, cases, BLOCK)
    with ProcessPoolExecutor(workers) as pool:
        blocks = {pool.submit(run, seed, low, min(low + BLOCK, cases)): low for low in lows}
        for done, block in enumerate(as_completed(blocks), 1):
            fresh = block.result()
            for check, line in fresh.first.items():
                if table.count(check) < _SHOWN:
                    print(f"{check}: {line}", file=sys.stderr, flush=True)
            table.add(fresh)
            if done % 20 == 0:
                spent = perf_counter() - began
                message = f"{done * BLOCK:,} cases in {spent:.0f} s, {table.wrong:,} wrong"
                print(message, file=sys.stderr, flush=True)
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("cases", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    asked = parser.parse_args(arguments)
    if asked.cases < 1 or asked.seed < 0 or asked.workers < 1:
        parser.error("expected at least one case and one worker, and a seed of 0 or more")
    began = perf_counter()
    table = campaign(asked.cases, asked.seed, asked.workers)
    print(f"{asked.cases:,} cases, seed {asked.seed}, {perf_counter() - began:.0f} s")
    print("\n".join(table.lines()))
    return 1 if table.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
