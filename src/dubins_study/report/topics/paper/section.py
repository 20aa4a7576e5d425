"""The paper's tables beside ours, and its figures redrawn."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.page.content import Column, Picture, Section, Table, count, digits
from dubins_study.report.page.style import HALF, new_figure
from dubins_study.report.paper import printed as paper
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.paper.figures import aspect_of, plot_paths
from dubins_study.study.path import Path

EXACT = "analytic"
_TITLES = {
    "6.1": "Test problem 1: start (0, 0, 2π/3), target (10, 5), R = 1.",
    "6.2": "Test problem 2: start (0, 0, 2π/3), target (−6, 3), R = 1.",
    "6.3": "Test problem 3: start (0, 0, π/3), target (−1, 5), R = 1.",
    "6.4": "Test problem 4: start (0, 0, π/3), target (−2, −5), R = 1.",
    "6.5": "Test problem 5: start (0, 0, 2π/3), target (−80, 20), three radii.",
}


def word_paths(results: Results, solver: str) -> dict[tuple[str, str], Path]:
    """(label, LS or RS) -> a solver's path, from the first attempt at each of the paper's."""
    rows = results.rows
    mine = rows[(rows["experiment"] == "paper") & (rows["solver"] == solver)]
    mine = mine[mine["branch"].isin(["LS", "RS"]) & mine["gap"].notna()]
    mine = mine.drop_duplicates(["label", "branch"])
    found = {
        (label, branch): results.path(index)
        for index, label, branch in zip(mine.index, mine["label"], mine["branch"], strict=True)
    }
    return {key: path for key, path in found.items() if path is not None}


def paper_section(results: Results) -> Section | None:
    """Tables 6.1-6.5 cell by cell, Figures 6.1-6.5, and every solver's score."""
    paths = word_paths(results, EXACT)
    if not paths:
        return None
    cells = paper.compare(paths)
    blocks: list[Table | Picture] = [_side_by_side(cells, number) for number in _TITLES]
    blocks.append(_scores(results))
    right = int((cells["verdict"] == "correct").sum())
    text = (
        f"{right} of the {len(cells)} printed lengths are correct roundings of the exact ones. The "
        "paper's optimal path is the shorter of LS and RS, its feasible path the longer. The audit "
        "below says what became of the others."
    )
    return Section("paper", "The paper's tables", text, tuple(blocks))


_MARK = {"correct": "", "misprint": " ✗", "differs": " ✗", "no answer": ""}


def _side_by_side(cells: pd.DataFrame, number: str) -> Table:
    own = cells[cells["table"] == number]
    records: list[dict[str, object]] = []
    marks: dict[tuple[int, str], str] = {}
    for (label, path), group in own.groupby(["label", "path"], sort=False):
        row = str(label).removeprefix("problem 5, ").replace("=", " = ")
        name = row if number == "6.5" else f"{str(path).capitalize()} path"
        printed: dict[str, object] = {"row": name, "source": "paper"}
        ours: dict[str, object] = {"row": "", "source": "exact"}
        for cell in group.to_dict("records"):
            quantity = str(cell["quantity"])
            printed[quantity] = f"{cell['printed']:.2f}{_MARK[cell['verdict']]}"
            ours[quantity] = None if pd.isna(cell["ours"]) else f"{cell['ours']:.6f}"
            if _MARK[cell["verdict"]]:
                marks[len(records), quantity] = "bad"
        records += [printed, ours]
    frame = pd.DataFrame.from_records(records, columns=["row", "source", *paper.QUANTITIES])
    frame[list(paper.QUANTITIES)] = frame[list(paper.QUANTITIES)].astype(object)
    columns = (
        Column("row", "", kind="text"),
        Column("source", "from", kind="text"),
        Column("z1", "left turn ζ₁"),
        Column("z2", "right turn ζ₂"),
        Column("z3", "straight ζ₃"),
        Column("f", "total f"),
    )
    caption = f"Table {number}. {_TITLES[number]} Lengths; ✗ marks what is not a correct rounding."
    return Table(f"paper-{number.replace('.', '-')}", caption, frame, columns, marks)


def _scores(results: Results) -> Table:
    rows = results.rows
    asked = rows[(rows["experiment"] == "paper") & rows["branch"].isin(["LS", "RS"])]
    exact = paper.compare(word_paths(results, EXACT))
    records = []
    for solver in solver_order(asked["solver"].tolist()):
        cells = paper.compare(word_paths(results, solver))
        off = (cells["ours"] - exact["ours"]).abs()
        turns = cells["quantity"] != "f"
        records.append(
            {
                "solver": solver,
                "answered": int(cells["ours"].notna().sum()),
                "printed": int((cells["verdict"] == "correct").sum()),
                "length_off": off[~turns].max(),
                "segment_off": off[turns].max(),
            }
        )
    columns = (
        Column("solver", "solver", kind="code"),
        Column("answered", f"cells of {len(exact)}", count),
        Column("printed", "as printed", count),
        Column("length_off", "largest error of f", digits(3)),
        Column("segment_off", "largest error of ζ", digits(3)),
    )
    caption = (
        "The same cells from each solver's LS and RS paths. A length may be right while its "
        "parts are not: compare both. Turns at less than the full rate count in proportion. Errors "
        "in the scenario's length unit."
    )
    return Table("paper-scores", caption, pd.DataFrame.from_records(records), columns)


def figures_section(results: Results) -> Section | None:
    """Figures 6.1-6.5, redrawn from the paths in the rows."""
    paths = word_paths(results, EXACT)
    pictures = []
    for problem in range(1, 6):
        own = {k: path for k, path in paths.items() if k[0].startswith(f"problem {problem}")}
        if own:
            pictures.append(_picture(results, problem, own))
    if not pictures:
        return None
    text = (
        "The paper's Figures 6.1–6.5, drawn from the controls in the rows. Both turning circles "
        "are faint; the arrow is the start heading, the ring the target."
    )
    return Section("paths", "The paper's figures", text, tuple(pictures))


def _picture(results: Results, problem: int, paths: dict[tuple[str, str], Path]) -> Picture:
    rows = results.rows
    frame = pd.DataFrame(
        [
            {"label": label, "branch": branch, "path": path, "length": path.total_length}
            for (label, branch), path in paths.items()
        ]
    )
    frame["rank"] = frame.groupby("label")["length"].rank(method="first")
    scenario = rows[(rows["experiment"] == "paper") & rows["label"].isin(frame["label"])]
    frame = frame.merge(
        scenario.drop_duplicates("label")[["label", "target_x", "target_y", "radius"]], on="label"
    )
    if problem == 5:
        frame = frame[frame["rank"] == 1]  # as the paper does: three radii, optimal paths only
    height = 0.85 + min(max(3.0 * aspect_of(frame), 1.6), 2.9)  # the rest is legend and labels
    figure = new_figure(HALF, height)
    plot_paths(figure.add_subplot(), frame)
    caption = f"Figure 6.{problem}. " + (
        "Optimal (solid) and feasible (dashed) path; length units."
        if problem != 5
        else "Optimal paths for three turning radii; length units."
    )
    return Picture(f"paths-{problem}", caption, figure, f"Paths of test problem {problem}", True)
