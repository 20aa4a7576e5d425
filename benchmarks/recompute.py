"""Recompute the benchmark's numbers from the Parquet rows.

They are the numbers of its front page and of README. Nothing but the rows is read.

    python -m benchmarks.recompute results/benchmark results/benchmark-report

reads the rows with pandas, and nothing of the package. It prints each number as the page has it and
as it comes out here, and ends with 1 if two differ. Intervals of shares are Wilson's, written out
below; those of the bootstrap are not repeated, only what they are about.
"""

from __future__ import annotations

import html
import re
import sys
from collections.abc import Iterator
from math import sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

TOURS = "benchmark-tour"
SUITES = ("benchmark-leg", "benchmark-pose", "benchmark-route", TOURS)
_Z = 1.959963984540054
_NEAR = 0.1 * (1 + 1e-6)  # radii


class Number(NamedTuple):
    """A number as printed and as recomputed."""

    name: str
    printed: str
    found: str

    @property
    def same(self) -> bool:
        return self.printed == self.found


def read(folder: Path) -> pd.DataFrame:
    """Rows of the suites of paths and tours.

    They have the columns `right`, `question` and `made`.
    """
    frames = []
    for suite in SUITES:
        parts = sorted((folder / suite.removeprefix("benchmark-") / "parts").glob("*.parquet"))
        frames.append(pd.concat([pd.read_parquet(part) for part in parts]).assign(suite=suite))
    rows = pd.concat(frames, ignore_index=True)
    rows = rows[(rows["initial_guess"] == "cold") & (rows["outcome"] != "unavailable")]
    rows = rows[rows["outcome"] != "unsupported"]
    late = rows["wall_s"] > rows["limit_s"]
    undecided = rows["verdict"].eq("undecided")
    left_open = undecided.groupby([rows["suite"], rows["scenario_id"], rows["branch"]])
    exists = rows.groupby(["scenario_id", "branch"])["reference_low"].transform("count") > 0
    return rows.assign(
        right=rows["verdict"].eq("optimal") & ~late,
        late=late & rows["verdict"].isin(["optimal", "none exists"]),
        path=exists & ~left_open.transform("any"),
        question=rows["scenario_id"] + rows["branch"],
        made=rows["outcome"] != "not_asked",
    )


def count(n: float) -> str:
    """A whole number with spaces, as printed.

    A space stands at thousands.
    """
    return f"{int(n):,}".replace(",", " ")


def percent(share: float) -> str:
    """A share in per cent with one decimal.

    Only a whole share is 100 %; one that is nearly whole is cut to 99.9 %.
    """
    value = 100 * share
    if value in (0.0, 100.0):
        return f"{value:.0f} %"
    return f"{min(value, 99.9):.1f} %"


def wilson(k: float, n: int) -> tuple[float, float]:
    """Wilson's score interval of k in n."""
    middle = k + _Z * _Z / 2
    half = _Z * sqrt(k * (n - k) / n + _Z * _Z / 4)
    return (middle - half) / (n + _Z * _Z), min(1.0, (middle + half) / (n + _Z * _Z))


def share_text(rows: pd.DataFrame) -> str:
    """The share of questions answered right, with its interval."""
    rates = rows.groupby("question")["right"].mean()
    low, high = wilson(rates.sum(), len(rates))
    ends = [percent(end).removesuffix(" %") for end in (low, high)]
    return f"{percent(rates.mean())} ({ends[0]} to {ends[1]})"


def text_of(page: str, section: str) -> str:
    """The text of a section of the page."""
    begin = page.index(f'<section id="{section}"')
    cut = page[begin : page.find("<section ", begin + 9)]
    plain = re.sub(r"<(script|style|svg)\b.*?</\1>", "", cut, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", plain)))


def belief(rows: pd.DataFrame, page: str) -> Iterator[Number]:
    """Counts of false claims by attempts and methods.

    They are attempts, methods that make false claims, denials, and claims of an optimum.
    """
    text = text_of(page, "belief").replace("\u202f", " ")
    asked = rows[rows["presolved"].ne(True)]
    false = asked["false_claim"].eq(True)
    liars = asked.loc[false, "solver"].nunique()
    yield Number("attempts", one(r"In ([\d ]+) attempts", text), count(asked["made"].sum()))
    yield Number("false claims", one(r"made ([\d ]+) false claims?", text), count(false.sum()))
    yield Number("methods that make them", one(r"routes ([\d ]+) methods?", text), count(liars))
    denied = asked["path"] & asked["claim"].eq("locally infeasible")
    if denied.any():
        yield Number("denials", one(r"([\d ]+) denials?", text), count(denied.sum()))
    optima = asked["claim"].eq("optimal") & asked["solver"].ne("analytic")
    yield Number("claims of an optimum", one(r"Of ([\d ]+) claims", text), count(optima.sum()))
    wrong = optima & asked["verdict"].eq("longer") & false
    yield Number("of these false", one(r"optimal ([\d ]+) are false", text), count(wrong.sum()))


def one(pattern: str, text: str) -> str:
    """First match of a pattern; a dash if none."""
    match = re.search(pattern, text)
    return match[1].strip() if match else "-"


def suites_of(rows: pd.DataFrame) -> pd.Series[str]:
    """Columns of the table of suites.

    Legs near a circle and elsewhere are apart.
    """
    near = rows["margin"].abs() <= _NEAR
    where = near.map({True: ", near a circle", False: ", elsewhere"})
    return rows["suite"].where(rows["suite"] != "benchmark-leg", rows["suite"] + where)


def decision(rows: pd.DataFrame, folder: Path) -> Iterator[Number]:
    """Cells of the table of where engines err.

    The false claims of each line are there too.
    """
    table = pd.read_csv(folder / "tables" / "decision.csv")
    least = rows["limit_s"].groupby([rows["suite"], rows["question"]]).transform("min")
    asked = rows[rows["path"] & (rows["limit_s"] <= least)].assign(column=suites_of(rows))
    columns = list(dict.fromkeys(asked.sort_values("suite")["column"]))
    columns = sorted(columns, key=lambda name: (SUITES.index(name.split(",")[0]), name))
    for line in table.to_dict("records"):
        kind = f"{line['formulation']}, {line['guesses']}"
        for place, column in enumerate(columns):
            cell = line.get(f"suite_{place}")
            if not isinstance(cell, str) or "\n" not in cell:
                continue
            solver, printed = cell.replace("\xa0", " ").split("\n")
            printed = re.sub(r" of \d+$", "", printed)
            chosen = asked[(asked["solver"] == solver) & (asked["column"] == column)]
            yield Number(f"{kind}: {solver}, {column}", printed, share_text(chosen))


def readme(rows: pd.DataFrame, text: str) -> Iterator[Number]:
    """The shares of README's table."""
    asked = rows[rows["path"]].assign(column=suites_of(rows))
    for line in re.findall(r"^\| [a-z].*`.*$", text, re.MULTILINE):
        for solver, printed in re.findall(r"`([^`]+)` ([\d.]+ % \([^)]+\))", line):
            chosen = asked[asked["solver"] == solver]
            every = {name: share_text(part) for name, part in chosen.groupby("column")}
            every |= {name: share_text(part) for name, part in chosen.groupby("suite")}
            number = printed if printed in every.values() else " / ".join(every.values())
            yield Number(f"README: {solver}", printed, number)


def findings(rows: pd.DataFrame, page: str) -> Iterator[Number]:
    """Numbers of the findings' sentences.

    Only those are computed that need no choice among methods.
    """
    text = text_of(page, "findings")
    legs = rows["via_x"].map(np.size, na_action="ignore").fillna(0) + 1
    routes = rows[(legs > 1) & rows["solver"].eq("analytic")]
    closed = (routes["right"] & routes["claim"].eq("optimal")).mean()
    printed = one(r"it proves ([\d.]+ %)", text)
    if printed == "-":
        return  # what these rows do not carry
    yield Number("routes that the search proves", printed, percent(float(closed)))
    printed = one(r"[Ww]ith \d+ legs it takes ([\d.]+ m?s)", text)
    most = routes.loc[legs[routes.index] == legs[routes.index].max(), "wall_s"].median()
    seconds = f"{1000 * most:.0f} ms" if most < 1 else f"{most:.2f} s"
    yield Number("seconds for the longest", printed, seconds)


def grids(rows: pd.DataFrame, page: str) -> Iterator[Number]:
    """Share of grid optima with another order than the tour.

    The optima are proved for a grid of eight headings; the tour is proved too.
    """
    in_time = rows["path"] & ~(rows["wall_s"] > rows["limit_s"])
    exact = rows["solver"].eq("analytic") & rows["claim"].eq("optimal") & rows["right"]
    orders = rows[exact].drop_duplicates("scenario_id").set_index("scenario_id")["visit_order"]
    program = rows["formulation"].isin(["tour MILP", "tour circuit"])
    eight = ~rows["solver"].str.contains("headings=|bounds")
    status = rows["native_status"].fillna("").str.lower()
    solved = status.str.endswith(("optimal", "gaplimit", "glp_opt", "glp_emipgap"))
    chosen = rows[in_time & program & eight & solved & rows["scenario_id"].isin(orders.index)]
    optima = chosen.drop_duplicates("scenario_id")
    printed = one(r"with 8 headings a point, ([\d.]+ %)", text_of(page, "findings"))
    other = []
    for row in optima.to_dict("records"):
        order = list(row["visit_order"])
        best = list(orders[row["scenario_id"]])
        same = order == best or (row["closed"] is True and order[::-1] == best)
        other.append(not same)
    yield Number("optima of a grid in another order", printed, percent(float(np.mean(other))))


def main(arguments: list[str]) -> int:
    """Print every number twice; 1 if two differ."""
    results = Path(arguments[0])
    report = Path(arguments[1])
    rows: Any = read(results)
    page = (report / "index.html").read_text(encoding="utf-8")
    paths = rows[rows["suite"] != TOURS]
    numbers = [*belief(paths, page), *decision(paths, report), *findings(paths, page)]
    numbers += grids(rows[rows["suite"] == TOURS], page)
    text = Path("README.md").read_text(encoding="utf-8")
    numbers += readme(paths, text)
    for number in numbers:
        mark = "  " if number.same else "! "
        print(f"{mark}{number.name}: {number.printed} | {number.found}")
    wrong = sum(not number.same for number in numbers)
    print(f"{len(numbers)} numbers, {wrong} differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
