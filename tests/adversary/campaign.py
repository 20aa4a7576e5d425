"""Attack the package with hard cases.

`python -m tests.adversary.campaign 1000000 2000` prints a table of the cases. It prints the first
counterexample of each check as a line to paste, and then exits with 1. The line needs `from
dubins_study import Scenario as S`, `Path`; `enclose`, `judge` and the others are from the room
`dubins_study.study`.
"""

import argparse
import os
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from time import perf_counter

import numpy as np
from flint import ctx

from dubins_study.study.path import CLAIMS
from tests.adversary import checks, frames, routes, routes_judged
from tests.adversary.generators import case, wrong_answer
from tests.adversary.oracle import bits
from tests.adversary.table import Table
from tests.adversary.truth import Truth

BLOCK = 500  # cases; what a frame holds, and what a worker does before it reports
_ROUTES = 20  # routes that a worker attacks before it reports
_SELF_CHECKED = 50  # one case in so many is sampled densely, and used against the oracle itself
_WITH_POINTS = 25  # one case in so many is followed by a route or a leg with a final heading


def run(seed: int, low: int, high: int) -> Table:
    """Run a seed's cases from `low` below `high`."""
    warnings.filterwarnings("ignore", ".* more than a full turn", UserWarning)  # which is meant
    table = Table()
    cases = [case(seed, number) for number in range(low, high)]
    answers: list[frames.Judged] = []
    for number, (kind, scenario) in enumerate(cases, low):
        rng = np.random.default_rng((seed, number, 1))
        table.generator = kind
        with ctx.workprec(bits(scenario)):
            truth = Truth.of(scenario)
            checks.closed_form(table, scenario, truth, rng)
            if rng.random() * _SELF_CHECKED < 1:  # by lot: generators take turns with the number
                truth.refine(rng)
                checks.oracle(table, scenario, truth, rng)
            sampled = checks.enclosures(table, scenario, truth)
            checks.bounds(table, scenario, truth)
        answers += frames.analytic(table, scenario, sampled)
        table.generator, asked = wrong_answer(rng, scenario)
        with ctx.workprec(bits(asked.scenario)):
            checks.answer(table, asked, Truth.of(asked.scenario), rng)
        length = asked.path.length
        claim = CLAIMS[number % len(CLAIMS)]
        bound = rng.choice([None, 1e9, np.inf, length, length * 0.9])
        answers.append(frames.judged(table.generator, *asked, claim, bound))
        answers.append(frames.judged("no path", scenario, "LS", None, claim))
        if number % _WITH_POINTS == 0:
            routes_judged.attacked(table, seed, number // _WITH_POINTS)
    frames.closed_forms(table, cases)
    frames.checks_of_frames(table, answers)
    return table


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=int)
    parser.add_argument("routes", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    asked = parser.parse_args()
    table = Table()
    began = perf_counter()
    work = ((run, asked.cases, BLOCK), (routes.run, asked.routes, _ROUTES))
    with ProcessPoolExecutor(asked.workers) as pool:
        blocks = [
            pool.submit(attack, asked.seed, low, min(low + size, n))
            for attack, n, size in work
            for low in range(0, n, size)
        ]
        for done, block in enumerate(as_completed(blocks), 1):
            table.add(block.result())
            if done % 20 == 0:
                spent = perf_counter() - began
                message = f"{done} of {len(blocks)} blocks in {spent:.0f} s, {table.wrong:,} wrong"
                print(message, *table.first.items(), sep="\n", file=sys.stderr, flush=True)
    summary = f"{asked.cases:,} cases, {asked.routes:,} routes, seed {asked.seed}"
    print(f"{summary}, {perf_counter() - began:.0f} s\n{table}")
    return 1 if table.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
