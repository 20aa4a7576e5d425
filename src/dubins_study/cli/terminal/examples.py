"""Examples of every command, shown at the end of its help and run by a test in this order.

The test runs them in one folder, in which `drive.csv` holds scenarios: later ones read what
earlier ones wrote.
"""

from __future__ import annotations

# the words of a command after `dubins-study` -> command lines, short enough for 80 columns
EXAMPLES: dict[str, tuple[str, ...]] = {
    "": (
        "dubins-study solve 10 5 --from 0 0 120deg",
        "dubins-study run paper",
        "dubins-study report results/paper",
    ),
    "solve": (
        "dubins-study solve 10 5 --from 0 0 120deg --radius 1",
        "dubins-study solve -6 3 --solver 'turn-rate-qp[n=100]' --plot path.svg",
        "dubins-study solve 0.5 0 --branch LR --json",
    ),
    "solvers": (
        "dubins-study solvers",
        "dubins-study solvers ipopt",
        "dubins-study solvers --json",
    ),
    "experiments": (
        "dubins-study experiments",
        "dubins-study experiments paper",
        "dubins-study experiments --json",
    ),
    "new": (
        "dubins-study new solver my_solver.py",
        "dubins-study new experiment my.toml",
    ),
    "new solver": ("dubins-study new solver another_solver.py",),
    "new experiment": ("dubins-study new experiment another.toml",),
    "run": (
        "dubins-study run paper",
        "dubins-study run paper --solver ipopt --solver nlp --out mine",
        "dubins-study run my.toml --jobs 2",
        "dubins-study run --scenarios drive.csv --solver ipopt --solver slsqp",
    ),
    "status": (
        "dubins-study status results/paper",
        "dubins-study status results/paper --json",
    ),
    "merge": ("dubins-study merge results/paper mine --out both",),
    "report": ("dubins-study report results/paper",),
    "compare": (
        "dubins-study compare results/paper both --out changes",
        "dubins-study compare results/paper both --fail-on-regression",
    ),
    "check-solver": (
        "dubins-study check-solver my_solver.py:MySolver",
        "dubins-study check-solver slsqp --check limits --check state",
    ),
    "audit": ("dubins-study audit",),
    "export": (
        "dubins-study export 10 5 --from 0 0 120deg --format mod",
        "dubins-study export 10 5 --model disjunctive --out model.nl",
    ),
}
