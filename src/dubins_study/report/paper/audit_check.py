"""Compares the computed audit with the committed one, and that with the closed form."""

from __future__ import annotations

from typing import Any

from dubins_study.report.paper.printed import PROBLEMS
from dubins_study.study.angle import parse_angle
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario

Record = dict[str, Any]
_AGREES = 1e-13  # of the larger of length and radius: some hundred roundings of a double


def contradictions(computed: Record, committed: Record) -> list[str]:
    """The numbers on which the code and the committed audit differ, one line each."""
    return [*_differences(computed, committed), *closed_form_differences(committed)]


def _differences(computed: Any, committed: Any, where: str = "") -> list[str]:
    if isinstance(computed, dict) and isinstance(committed, dict):
        pairs = [
            (computed.get(key), committed.get(key), f"{where}{'.' if where else ''}{key}")
            for key in dict.fromkeys((*computed, *committed))
        ]
    elif isinstance(computed, list) and isinstance(committed, list):
        if len(computed) != len(committed):
            return [f"{where}: {len(computed)} computed, {len(committed)} committed"]
        pairs = [
            (ours, theirs, f"{where}[{_name(ours, i)}]")
            for i, (ours, theirs) in enumerate(zip(computed, committed, strict=True))
        ]
    else:
        same = computed == committed
        return [] if same else [f"{where}: computed {computed!r}, committed {committed!r}"]
    return [line for pair in pairs for line in _differences(*pair)]


def _name(record: Any, place: int) -> str:
    """What a person calls an entry of a list."""
    keys = ("table", "label", "path", "quantity", "where")
    named = [str(record[key]) for key in keys if key in record] if isinstance(record, dict) else []
    return ", ".join(named) or str(place)


def closed_form_differences(committed: Record) -> list[str]:
    """Cells whose committed value is not what `study.closed_form.shortest` computes."""
    lines = []
    for cell in committed.get("cells", ()):
        problem = PROBLEMS[cell["label"]]
        heading = parse_angle(f"{problem.heading.numerator}pi/{problem.heading.denominator}")
        scenario = Scenario(0, 0, heading, *problem.target, problem.radius)
        word = shortest(scenario, cell["word"])
        ours = None if word is None else _quantity(cell, word.segments, problem.radius)
        exact = float(cell["exact"])
        if ours is None or abs(ours - exact) > _AGREES * max(exact, problem.radius):
            where = f"cells[{_name(cell, 0)}]"
            lines.append(f"{where}: the closed form has {ours!r}, committed {cell['exact']}")
    return lines


def _quantity(cell: Record, segments: tuple[float, float], radius: int) -> float:
    turn, straight = (length * radius for length in segments)
    return {"z3": straight, "f": turn + straight}.get(cell["quantity"], turn)
