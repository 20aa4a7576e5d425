"""What a reader does next: who reads the page, the command for it, and where to read on."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.command import run_command
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Table


def cases_table(results: Results) -> Table:
    """One line for each kind of reader: the command of their own case, and the next section."""
    run = run_command(results.folders[0].manifest, "--solver FILE.py:CLASS --out MINE")
    lines = [
        (
            "You plan paths for a vehicle.",
            "Take the closed form; from Python it is dubins_study.solve. X and Y are the target, "
            "and --radius sets R.",
            "dubins-study solve X Y --from X0 Y0 HEADING",
            "Explore the problem",
        ),
        (
            "You have a problem without a formula.",
            "Take over the formulation and the initial guess rather than the engine, and check "
            "what it claims.",
            "dubins-study solvers",
            "Formulation by engine",
        ),
        (
            "You write a solver.",
            "Have it checked, then asked the questions of this page; the report of both folders "
            "has it beside the others.",
            f"dubins-study check-solver FILE.py:CLASS\n{run}\ndubins-study report FOLDER MINE",
            "Single attempts",
        ),
        (
            "You read the paper and want its errors.",
            "Every printed number beside the exact one.",
            "dubins-study audit",
            "The audit of the paper",
        ),
    ]
    frame = pd.DataFrame(lines, columns=["reader", "advice", "command", "section"])
    shown = (
        *columns(kind="text", reader="and in your case?"),
        *columns(kind="prose", advice="what to do"),
        *columns(kind="code", command="command"),
        *columns(kind="section", section="read on"),
    )
    caption = (
        "Words in capitals are yours to fill in: FILE.py:CLASS is your solver's file and class, "
        "FOLDER the results folder of this page. An angle may carry its unit: 120deg."
    )
    return Table("cases", caption, frame, shown, stacked=True)
