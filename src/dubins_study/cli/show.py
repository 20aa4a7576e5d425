"""What the command line prints and draws, from what the library returns."""

from __future__ import annotations

import json
from collections.abc import Sequence
from io import StringIO
from pathlib import Path as FilePath

from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.attempt import Answer
from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.registry import Entry
from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.printable import plain
from dubins_study.study.scenario import Scenario


class ShowError(DubinsStudyError, ValueError):
    """Something that the command line cannot read or draw."""


def check_words(target: list[str], rest: list[str], command: str) -> None:
    """Refuse options that there are not, and words after the target.

    Raises:
        ShowError: naming the first of them.
    """
    for word in (*target, *rest):
        if word.startswith("-") and not _is_number(word):
            raise ShowError(f"no such option: {word}; see dubins-study {command} --help")
    if rest:
        raise ShowError(f"unexpected argument {rest[0]!r}; expected a target of two numbers, X Y")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def scenario(x: str, y: str, start: tuple[str, str, str], radius: str, speed: str) -> Scenario:
    """A scenario from the texts of the command line.

    Raises:
        ShowError, AngleError, ScenarioError: naming the field, its value and what was expected.
    """
    try:
        heading = parse_angle(start[2])
    except AngleError as error:
        raise AngleError(f"heading: {error}") from None
    return Scenario(
        x=_number("x", start[0]),
        y=_number("y", start[1]),
        heading=heading,
        target_x=_number("target_x", x),
        target_y=_number("target_y", y),
        radius=_number("radius", radius),
        speed=_number("speed", speed),
    )


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ShowError(f"{name} is {text!r}; expected a number") from None


def answer_json(answer: Answer) -> str:
    """One object: the answer, its segments, and the question."""
    path = answer.path
    pieces = [] if path is None else zip(path.curvature, path.length, strict=True)
    shown = {
        name: getattr(answer, name)
        for name in (
            *(
                "word",
                "length",
                "travel_time",
                "gap",
                "verdict",
                "claim",
                "outcome",
                "solver",
                "branch",
            ),
            *("miss", "region", "margin", "reference", "reference_word", "curvature_excess"),
            *("claimed_length", "lower_bound", "false_claim", "wrong_basin", "proof"),
            *("reference_low", "reference_high", "pmp_residual", "cut_margin", "false_bound"),
            *("native_status", "message", "wall_s"),
        )
    }
    shown["segments"] = [
        {"turn": _letter(k), "length": float(length), "curvature": float(k)} for k, length in pieces
    ]
    shown["tied_words"] = list(answer.tied_words)
    return json.dumps(shown, indent=2, allow_nan=False)


def _letter(curvature: float) -> str:
    return "L" if curvature > 0 else "R" if curvature < 0 else "S"


def answer_text(answer: Answer) -> str:
    """A few lines for a person."""
    lines = [f"verdict   {answer.verdict}", f"claim     {answer.claim}  ({answer.solver})"]
    lines.append(f"proof     {answer.proof}")
    if answer.length is not None:
        ties = [word for word in answer.tied_words if word != answer.reference_word]
        tied = f"  (tied with {', '.join(ties)})" if ties else ""
        lines = [
            f"word      {answer.word or 'none: the target is the start'}{tied}",
            f"length    {answer.length:.12g}",
            f"time      {answer.travel_time:.12g}",
            *lines,
            f"gap       {'–' if answer.gap is None else format(answer.gap, '.3g')}",
            f"miss      {'–' if answer.miss is None else format(answer.miss, '.3g')}",
        ]
    lines.append(f"region    {answer.region}, {answer.margin:.3g} R from the nearer turning circle")
    if answer.false_claim:
        lines.append("false claim: the claim is stronger than the verdict")
    if answer.false_bound:
        lines.append("false bound: the solver's lower bound lies above the shortest length")
    if answer.outcome != Outcome.RETURNED:
        lines.append(f"outcome   {answer.outcome}")
    if answer.message:
        lines.append(f"message   {plain(answer.message)}")
    return "\n".join(lines)


def solved(scenario: Scenario, solver: str, branch: str, profile: str, limit: float) -> Answer:
    """The closed form's answer, or another solver's from a process of its own."""
    if solver == "analytic":
        from dubins_study.solvers.attempt import solve

        return solve(scenario, solver, branch, profile=profile, limit=limit)
    from dubins_study.experiments.engines.isolated import solve_isolated

    return solve_isolated(scenario, solver, branch, profile=profile, limit=limit)


def no_answer(answer: Answer) -> str | None:
    """Why the solver was not asked at all, if so."""
    if answer.outcome not in (Outcome.UNAVAILABLE, Outcome.UNSUPPORTED):
        return None
    return f"solver {answer.solver!r} is {answer.outcome}: {plain(answer.message)}"


def plot(answer: Answer, file: FilePath) -> None:
    """Draw the answer's path, with its turning circles and the target.

    Raises:
        ShowError: if there is no path, the format is unknown or the file cannot be written.
    """
    from dubins_study.report.path_plot import save_path

    if file.suffix not in (".svg", ".pdf", ".png"):
        raise ShowError(f"--plot is {str(file)!r}; expected a name ending in .svg, .pdf or .png")
    if answer.path is None:
        raise ShowError(f"--plot: {answer.solver} returned no path")
    try:
        save_path(answer.scenario, answer.path, answer.solver, file)
    except OSError as error:
        raise ShowError(f"--plot: cannot write {file}: {error.strerror}") from None


def save(text: str, file: FilePath) -> None:
    """Write an exported model.

    Raises:
        ShowError: if the file cannot be written.
    """
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ShowError(f"--out: cannot write {file}: {error.strerror}") from None


def solvers_json(entries: list[Entry]) -> str:
    """A list of objects; `reason` is null for a solver that is available."""
    listed = [entry._asdict() | {"available": entry.reason is None} for entry in entries]
    return json.dumps(listed, indent=2)


def solvers_text(entries: list[Entry]) -> str:
    """A table for the terminal."""
    rows = [
        (
            entry.name,
            entry.method,
            entry.guarantee,
            ", ".join(entry.branches),
            "yes" if entry.reason is None else f"no: {plain(entry.reason)}",
            entry.summary,
        )
        for entry in entries
    ]
    head = ("solver", "method", "guarantee", "branches", "available", "summary")
    return table(head, rows)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Rows as aligned text, numbers to the right; as wide as it needs to be."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for place, name in enumerate(head):
        cells = [row[place] for row in rows]
        numbers = all(cell.replace(".", "").replace("e-", "").isdigit() for cell in cells if cell)
        # as text: a word that a folder holds may look like markup
        shown.add_column(Text(name), no_wrap=True, justify="right" if numbers else "left")
    for row in rows:
        shown.add_row(*(Text(cell) for cell in row))
    written = StringIO()
    Console(file=written, width=500, highlight=False).print(shown)
    return "\n".join(line.rstrip() for line in written.getvalue().strip("\n").splitlines())


# columns of the report's summary that fit a terminal, and how they are called there
_SUMMARY = {
    "solver": "solver",
    "attempts": "asked",
    "optimal": "optimal",
    "none exists": "none exists",
    "longer": "longer",
    "misses": "misses",
    "none": "none",
    "false_claims": "false claims",
    "wrong_basins": "wrong basins",
    "wall_s": "median ms",
}


def report_text(page: FilePath) -> str:
    """The summary that the report wrote, and where its page is."""
    import csv

    with (page.parent / "tables" / "summary.csv").open(encoding="utf-8", newline="") as stream:
        rows = [
            [
                plain(row[name]) if name != "wall_s" else _milliseconds(row[name])
                for name in _SUMMARY
            ]
            for row in csv.DictReader(stream)
        ]
    return f"{table(list(_SUMMARY.values()), rows)}\n\npage: {plain(str(page))}"


def _milliseconds(seconds: str) -> str:
    return f"{float(seconds) * 1e3:.3g}" if seconds else ""
