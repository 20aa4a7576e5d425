"""`dubins-study solve` of tours.

Closed paths, free starts and headings at via points are tested too.
"""

import json
import math
import shlex
import warnings
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from dubins_study import Scenario, plot_path, solve
from dubins_study.cli.solving.answer_text import answer_json, answer_text
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments import solve as module
from dubins_study.study.scenario_frame import solve_command
from tests.unit.cli.conftest import asked, line_of

POINTS = "x,y,name\n9,-6,mill\n3,7,oak\n-5,4,\n4,-3,ford\n"


@pytest.fixture
def file(tmp_path):
    place = tmp_path / "points.csv"
    place.write_text(POINTS)
    return place


def json_of(*words):
    return json.loads(asked("solve", *words, "--json").stdout)


def test_the_text_of_a_tour_names_its_points(file):
    """The text of a tour names its points.

    It has their names, or numbers, and what the order of the file would have cost.
    """
    asked_for = ("--via-file", str(file), "--order", "free", "--from", "0", "0", "30deg", "12", "3")

    text = asked("solve", *asked_for).stdout
    answer = json_of(*asked_for)

    names = ["mill", "oak", "3", "ford"]
    assert line_of("order", text) == ", ".join(names[place] for place in answer["order"])
    given = solve(Scenario(0, 0, "30deg", 12, 3, via=[(9, -6), (3, 7), (-5, 4), (4, -3)]))
    longer = 100 * (given.length / answer["length"] - 1)
    assert line_of("given order", text) == f"{given.length:.12g}, {longer:.3g} % longer"
    assert answer["given_order_length"] == pytest.approx(given.length, rel=1e-12)


def test_points_of_one_name_have_their_numbers(tmp_path):
    """Points of one name have their numbers.

    An order that a solver makes worse than the given one is not called shorter.
    """
    file = tmp_path / "twins.csv"
    file.write_text("x,y,name\n3,4,a\n6,1,a\n-3,-2,\n")
    tour = ("--via-file", str(file), "--order", "free", "--solver", "tour-order")

    text = asked("solve", *tour).stdout

    assert line_of("order", text) == "3, a (1), a (2)"
    length = float(line_of("length", text))
    shown = line_of("given order", text).split()
    assert shown[3] == ("longer" if float(shown[0].strip(",")) > length else "shorter")


def test_a_tour_may_end_at_its_start_with_another_heading():
    words = ("0", "0", "--via", "5", "5", "--via", "-5", "5", "--order", "free")

    answer = json_of(*words)

    orders = [[(5, 5), (-5, 5)], [(-5, 5), (5, 5)]]
    best = min(solve(Scenario(0, 0, 0, 0, 0, via=via)).length for via in orders)
    assert answer["length"] == pytest.approx(best, rel=1e-9)
    assert answer["proof"] == "proved"


def test_a_heading_of_more_than_a_turn_is_taken_as_it_is(recwarn):
    answer = json_of("9", "0", "--via", "4", "1", "--via-heading", "1", "450deg")

    turned = json_of("9", "0", "--via", "4", "1", "--via-heading", "1", "90deg")
    assert answer["length"] == pytest.approx(turned["length"], rel=1e-9)
    assert not recwarn.list


def test_a_tour_is_the_shortest_of_all_orders(file):
    """A tour is the shortest of all orders.

    Without X Y it ends at whichever point comes last.
    """
    answer = json_of("--via-file", str(file), "--order", "free", "--from", "0", "0", "free")

    points = [(9, -6), (3, 7), (-5, 4), (4, -3)]
    lengths = {
        order: solve(
            Scenario(
                heading=None,
                target_x=points[order[-1]][0],
                target_y=points[order[-1]][1],
                via=[points[place] for place in order[:-1]],
            )
        ).length
        for order in permutations(range(4))
    }
    best = min(lengths, key=lengths.__getitem__)
    assert answer["proof"] == "proved"
    assert answer["length"] == pytest.approx(lengths[best], rel=1e-9)
    assert tuple(answer["order"]) == best


def test_a_closed_path_ends_as_it_starts(file, tmp_path):
    drawing = tmp_path / "tour.svg"
    written = tmp_path / "tour.json"
    options = ("--closed", "--order", "free", "--from", "1", "2", "free")
    files = ("--plot", str(drawing), "--geojson", str(written))

    answer = json_of("--via-file", str(file), *options, *files)

    assert answer["proof"] == "proved"
    path, *points = json.loads(written.read_text())["features"]
    first, *_, last = path["geometry"]["coordinates"]
    assert first == pytest.approx([1, 2])
    assert last == pytest.approx([1, 2], abs=1e-9)
    start, end = (path["properties"][f"{name}_heading_rad"] for name in ("start", "end"))
    assert math.remainder(end - start, 2 * math.pi) == pytest.approx(0, abs=1e-9)
    shown = [each["properties"] for each in points]
    assert [each["name"] for each in shown] == ["mill", "oak", None, "ford", None]
    by_visit = sorted((each for each in shown if each["kind"] == "via"), key=lambda p: p["visit"])
    assert [each["index"] - 1 for each in by_visit] == answer["order"]
    assert drawing.stat().st_size > 1000


def test_headings_at_points_are_met(tmp_path):
    """Headings at points are met.

    They come from a column of the file, or by the number of a point; the last one's is the
    target's.
    """
    file = tmp_path / "lines.csv"
    file.write_text("x,y,heading\n4,1,90deg\n6,-2,free\n10,5,-pi/2\n")
    typed = ("10", "5", "--via", "4", "1", "--via", "6", "-2", "--via-heading", "1", "90deg")

    answers = [
        json_of("--via-file", str(file)),
        json_of(*typed, "--final-heading", "-pi/2"),
    ]

    assert answers[0]["length"] == answers[1]["length"]
    asked_for = Scenario(
        target_x=10, target_y=5, via=[(4, 1, "90deg"), (6, -2)], final_heading="-90deg"
    )
    answer = solve(asked_for)
    assert answer.length == pytest.approx(answers[0]["length"], rel=1e-12)
    assert answer.path.at(answer.visits[0])[0, 2] % (2 * math.pi) == pytest.approx(math.pi / 2)


def test_the_given_order_takes_a_tenth_of_the_limit(file, monkeypatch):
    """The given order takes a tenth of the limit.

    It is only compared with: a tour of many points would take twice its limit.
    """
    limits = []

    def timed(scenario, *arguments, limit, **others):
        limits.append((str(scenario.order), limit))
        return solve(scenario, *arguments, limit=limit, **others)

    monkeypatch.setattr(module, "solve", timed)
    asked("solve", "--via-file", str(file), "--order", "free", "--time-limit", "20")

    assert limits == [("free", 20.0), ("given", 2.0)]


@pytest.mark.parametrize("turns", [-3, 1])
def test_a_start_heading_is_shown_within_half_a_turn(file, turns):
    heading = 1.0 + turns * math.tau

    answer = json_of("--via-file", str(file), "--from", "0", "0", f"{heading}rad")

    assert answer["start_heading"] == pytest.approx(1.0)


def test_no_proved_path_has_a_gap_below_zero():
    """No proved path has a gap below zero.

    Rounding may make it shorter than the proven bound by a few ulps.
    """
    exact = solve(Scenario(target_x=9, target_y=1, via=[(3, 4)], order="free"))
    answer = replace(exact, gap=-1e-16)
    assert answer.proof == "proved"

    assert line_of("gap", answer_text(answer)) == "0"
    assert json.loads(answer_json(answer))["gap"] == 0.0
    unproved = replace(answer, proof="extremal")
    assert json.loads(answer_json(unproved))["gap"] == -1e-16


REFUSED = {
    "3 4 --order free --closed": "X Y and --closed are given; a closed path ends at its start",
    "3 4 --order sideways --via 1 2": "order is 'sideways'; expected given or free",
    "--order free": "via is empty; expected points to pass, which a tour without a target needs",
    "--closed": "via is empty; expected points to pass, which a closed path needs",
    "--closed --via 3 4 --final-heading 3": "final_heading is 3.0, but a closed path ends as it",
    "3 4 --via-heading 1 90deg": "--via-heading: place 1; there is no via point",
    "3 4 --via 1 2 --via-heading 2 90deg": "--via-heading: place 2; expected one from 1 to 1",
    "3 4 --via 1 2 --via-heading 1 90degg": "'90degg' is not an angle",
    "3 4 --via 1 2 --via 1 2 --order free": "(1.0, 2.0) is a point of the tour twice, as points",
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_is_refused(words):
    with pytest.raises(DubinsStudyError) as refused:
        asked("solve", *words.split())

    assert REFUSED[words] in str(refused.value)


@pytest.mark.parametrize("seed", range(12))
def test_the_command_of_a_scenario_asks_it(seed):
    random = np.random.default_rng(seed)
    closed, free_order, free_start = random.random(3) < 0.5
    via = [tuple(random.uniform(-9, 9, 2)) for _ in range(3)]
    if random.random() < 0.5:
        via[1] = (*via[1], float(random.uniform(-3, 3)))
    x, y = random.uniform(-9, 9, 2)
    target = {} if closed else {"target_x": x, "target_y": y}
    scenario = Scenario(
        heading=None if free_start else float(random.uniform(-3, 3)),
        radius=0.5,
        via=via,
        order="free" if free_order else "given",
        closed=bool(closed),
        **target,
    )
    answer = solve(scenario)

    command = solve_command(answer.row() | {"solver": "analytic"})
    _, solve_, *words = shlex.split(command)
    again = json.loads(asked(solve_, "--json", *words).stdout)

    assert again["length"] == answer.length
    assert again["order"] == answer.order


def test_a_tour_is_drawn_with_its_points_in_the_order_of_visits():
    """A tour's points have the numbers of visits.

    The numbers beside the points, along the path, are 1, 2, 3.
    """
    answer = solve(Scenario(heading=0.3, via=[(9, -6), (3, 7), (-5, 4)], order="free", closed=True))

    [axes] = plot_path(answer).axes

    numbers = {text.get_text(): text.xy for text in axes.texts if text.get_text().isdigit()}
    points = answer.scenario.points[1:]
    assert {int(text): tuple(xy) for text, xy in numbers.items()} == {
        place: tuple(points[i]) for place, i in enumerate(answer.order, 1)
    }


def drawn_texts(scenario, names):
    """Texts beside points, by their points.

    The texts below the plot come with them.
    """
    answer = solve(scenario, limit=2)
    [axes] = plot_path(answer, names=names).axes
    beside = {tuple(text.xy): text.get_text() for text in axes.texts if text.get_text()}
    return answer, beside, axes.get_xlabel().replace("\u00a0", " ")


def test_names_stand_beside_few_points():
    """Names stand beside few points.

    They stand behind the numbers of visits; the last point of an open tour has both, a target its
    name.
    """
    via = [(9, -6), (3, 7), (-5, 4)]
    names = ["mill", "oak", ""]

    answer, beside, below = drawn_texts(Scenario(via=via, order="free"), names)
    numbered = {via[i]: f"{n} {names[i]}".strip() for n, i in enumerate(answer.order, 1)}
    assert beside == {(0.0, 0.0): "start", **numbered}
    assert below == "x"

    to_home = Scenario(target_x=20, target_y=0, via=via, order="free")
    _, beside, _ = drawn_texts(to_home, [*names, "home"])
    assert beside[20.0, 0.0] == "home"


def test_names_of_many_points_stand_below_the_plot():
    via = [(5.0 * place, (-1.0) ** place) for place in range(1, 15)]
    names = [f"field {place}" for place in range(14)]

    answer, beside, below = drawn_texts(Scenario(via=via, order="free"), names)

    assert set(beside.values()) <= {"start", *map(str, range(1, 15))}
    expected = ", ".join(f"{n} {names[i]}" for n, i in enumerate(answer.order, 1))
    assert " ".join(below.split()) == f"x {expected}"


def test_texts_do_not_overlap():
    """Texts do not overlap.

    Of points that lie close some are left without a name, or without a text.
    """
    via = [(4 + 0.1 * place, 3.0) for place in range(6)]
    names = [f"point number {place}" for place in range(6)]

    _, beside, _ = drawn_texts(Scenario(via=via, target_x=9, target_y=0), names)

    assert 1 < len(beside) < 8


def test_letters_that_the_font_lacks_are_named_once(caplog, tmp_path):
    """Letters that the font lacks are named once.

    Matplotlib warns of each letter, with its own file and line.
    """
    answer = solve(Scenario(via=[(1, 5), (6, 3)], order="free"))

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plot_path(answer, tmp_path / "tour.png", names=["北京", "上海"])

    [record] = caplog.records
    assert "font lacks letters" in record.getMessage()
