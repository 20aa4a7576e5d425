"""Attempts on the page, driven as by a reader.

The plot, the drawer of one attempt, and the worst ten are used.
"""

import json
import math
import os
import re
import stat
import subprocess
import sys
from pathlib import Path as FilePath
from typing import Any

import pytest

from dubins_study import Scenario, solve
from dubins_study.study.path import Path
from dubins_study.study.scenario_frame import solve_command
from dubins_study.study.words import Claim
from tests.browser_tab import PHONE
from tests.unit.report.results_folder import attempt, write_folder
from tests.unit.report.topic_page import topic_page

# What would run if it were not text: in HTML, in a template of Bokeh's, in a shell. A mark that
# turns the text around is written out by the reader of the results (`study.printable`).
HOSTILE = "</script><img src=x onerror=alert(1)>@{row}{safe} \"q\" 'p' $(touch pwned) `touch pwned`"
MINE = f"mine[{HOSTILE}]"
RAW = "slsqp[model=joint,order=RLS]"
LONG = "turn-rate-qp[n=20]"
ODD = Scenario(0.1, -1 / 3, 2.5, 4 / 3, 1.7, 0.7, 1.3, label="odd numbers")


def solved(scenario: Scenario, solver: str, branch: str = "best") -> dict[str, Any]:
    """A row of what a solver really answers."""
    answer = solve(scenario, solver, branch)
    row = attempt(scenario, solver, branch, path=answer.path, claim=Claim(answer.claim))
    return row | {"scenario_id": "0ddba11", "formulation": "solved here", "engine": solver[:5]}


def rows() -> list[dict[str, Any]]:
    """Three solvers at forty targets.

    A few questions are really asked.
    """
    records = [solved(ODD, solver) for solver in ("analytic", RAW, LONG)]
    records.append(solved(ODD, "analytic", "RL"))
    for number in range(40):
        angle = 2 * math.pi * number / 40
        x, y = (2.5 + number / 10) * math.cos(angle), (2.5 + number / 10) * math.sin(angle)
        scenario = Scenario(target_x=x, target_y=y, label=HOSTILE if number % 2 else "plain")
        for solver in ("fine", MINE, "far"):
            wrong = solver != "fine" and number % 3 == 0
            path: Any = Path(scenario.start, [0.0], [1.0 + number]) if wrong else "exact"
            row = attempt(scenario, solver, path=path, claim=Claim.LOCAL)
            row |= {"scenario_id": f"{number:07x}", "message": f"{HOSTILE}\nsecond line"}
            records.append(row | {"engine": "MyEngine", "wall_s": 1e-3 * (1 + number)})
    return records


def address_of(place: FilePath, records: list[dict[str, Any]]) -> str:
    """A page of these attempts, written below a folder."""
    folder = write_folder(place / "mine", "mine", records, time_limit_s=30.0)
    return topic_page(folder, place / "report", "single attempts").as_uri()


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    return address_of(tmp_path_factory.mktemp("attempts"), rows())


@pytest.fixture
def plot(new_tab, address: str):
    """`plot(**options)`: the page with its plot drawn."""

    def opened(at: str = "", of: str = address, **options):
        page = new_tab(reduced_motion="reduce", **options)
        page.goto(of + at)
        page.locator("#attempts > details").evaluate("part => { part.open = true }")
        drawn_part(page, "plot")
        return page

    return opened


def drawn_part(page, name: str) -> None:
    """Scroll to a part of the section.

    It is drawn when it comes near.
    """
    page.locator(f"#attempts-{name}").scroll_into_view_if_needed()
    page.wait_for_selector(f"#attempts-{name}[data-ready=yes]")


def show(page, attempt_row: int) -> None:
    """Open an attempt in the drawer."""
    page.evaluate("async i => attempts.show(await attempts.open(), [i])", attempt_row)


def row(page, solver: str, number: int = 0, branch: str = "best") -> int:
    """Number of an attempt on the page.

    It is the solver's attempt at a scenario.
    """
    return page.evaluate(
        """async ([solver, id, branch]) => {
            const data = await attempts.open();
            for (let i = 0; i < data.count; i += 1) {
                if (data.text("solver", i) === solver && data.ofScenario("scenario_id", i) === id
                    && data.text("branch", i) === branch) return i;
            }
            return -1;
        }""",
        [solver, f"{number:07x}" if number >= 0 else "0ddba11", branch],
    )


def position(page, attempt_row: int) -> tuple[float, float]:
    """Position of a coloured attempt, in screen pixels.

    The plot is scrolled there.
    """
    page.locator("#attempts-plot .canvas").evaluate(
        "node => node.scrollIntoView({block: 'center'})"
    )
    page.wait_for_timeout(200)
    return tuple(
        page.evaluate(
            """row => {
                const fig = attempts.drawn.figure();
                const view = [...Bokeh.index.roots].find((root) => root.model === fig);
                const points = fig.renderers[1].data_source.data, k = points.row.indexOf(row);
                const box = view.el.getBoundingClientRect(), {x_scale, y_scale} = view.frame;
                return [box.left + x_scale.compute(points.x[k]),
                        box.top + y_scale.compute(points.y[k])];
            }""",
            attempt_row,
        )
    )


def choose(page, *solvers: str) -> None:
    """Colour these solvers only, by their boxes."""
    box = page.locator("details.solvers")
    if box.get_attribute("open") is None:
        box.locator("summary").click()
    box.get_by_role("button", name="none").click()
    for solver in solvers:
        page.locator(f"details.solvers label[title^={solver}]").click()


def axes(page) -> list[float]:
    return page.evaluate(
        """() => { const {x_range: x, y_range: y} = attempts.drawn.figure();
                   return [x.start, x.end, y.start, y.end]; }"""
    )


@pytest.mark.slow
def test_the_library_is_started_only_for_those_who_look(new_tab, address: str):
    """Nothing is unpacked before the section comes near."""
    page = new_tab()
    page.goto(address)

    assert page.evaluate("typeof window.Bokeh") == "undefined"


def test_every_attempt_is_a_point(plot):
    """Every attempt is a point.

    Those of chosen solvers are coloured. The text says how many have no place in the plot.
    """
    page = plot()
    records = rows()
    gaps = sum(one["gap"] is not None for one in records)
    shown = page.evaluate(
        "() => attempts.drawn.figure().renderers.map((one) => one.data_source.data.x.length)"
    )

    assert sum(shown[:2]) == gaps < len(records)
    choose(page, "fine", "far")
    status = page.locator("#attempts-plot > p[role=status]")
    right = sum(one["gap"] is not None for one in records if one["solver"] in ("fine", "far"))
    assert f"{right} coloured points and {gaps - right} faint ones" in status.text_content()
    assert f"{80 - right} more have no gap" in status.text_content()
    page.get_by_text("show the other solvers, faint").click()
    assert f"{right} coloured points and 0 faint ones" in status.text_content()


@pytest.mark.slow
def test_axes_are_chosen_and_named_with_their_units(plot):
    """Axes are chosen and named with their units.

    They are logarithmic but for angles; zeros stand at the floor that the title names.
    """
    page = plot()
    page.get_by_label("horizontal").select_option("bearing")
    page.get_by_label("vertical").select_option("miss")
    page.wait_for_function("() => attempts.drawn.figure().left[0].axis_label.startsWith('miss')")
    below, left, floor, *kinds = page.evaluate(
        """() => {
            const fig = attempts.drawn.figure();
            return [fig.below[0].axis_label, fig.left[0].axis_label,
                    Math.min(...fig.renderers[1].data_source.data.y),
                    fig.x_scale.type, fig.y_scale.type];
        }"""
    )

    assert below.endswith("(degrees)")
    assert 0 < floor < min(one["miss"] for one in rows() if one["miss"])
    assert left.endswith(f"(R); 0 is drawn at 1e−{-round(math.log10(floor))}")
    assert kinds == ["LinearScale", "LogScale"]


@pytest.mark.slow
def test_solvers_are_found_by_words_and_by_engine(plot):
    """Solvers are filtered by words and by engine.

    The list follows the filter; a group's button colours the group.
    """
    page = plot()
    page.locator("details.solvers summary").click()
    page.locator("details.solvers").get_by_role("searchbox").fill("FINE")
    assert page.locator("details.solvers .groups label").count() == 1

    page.locator("details.solvers").get_by_role("searchbox").fill("")
    page.locator("details.solvers select").select_option("engine")
    page.get_by_role("button", name="only these of MyEngine").click()
    assert page.locator(".marks li").count() == 3
    page.get_by_role("button", name="no longer colour").first.click()
    assert page.locator(".marks li").count() == 2


def test_verdicts_are_filtered(plot):
    """Only attempts with a chosen verdict are drawn."""
    page = plot()
    choose(page, "fine", "far")
    page.get_by_label("vertical").select_option("miss")
    page.wait_for_function("() => attempts.drawn.figure().left[0].axis_label.startsWith('miss')")
    filters = page.locator(".filters details", has_text="verdicts")
    filters.locator("summary").click()
    filters.get_by_role("button", name="none").click()
    status = page.locator("#attempts-plot > p[role=status]")
    assert "0 coloured points and 0 faint" in status.text_content()

    filters.get_by_label("misses").check()
    missed = sum(one["verdict"] == "misses" for one in rows() if one["solver"] == "far")
    assert f"{missed} coloured points" in status.text_content()


@pytest.mark.slow
def test_a_point_says_what_it_is_when_the_pointer_is_over_it(plot):
    """The pointer over a point shows its facts.

    It shows names and numbers, and names from outside as text.
    """
    page = plot()
    choose(page, "mine")
    x, y = position(page, row(page, MINE, 1))
    page.mouse.move(x - 4, y)
    page.mouse.move(x, y)
    tooltip = page.locator(".attempt-tooltip").first
    tooltip.wait_for()

    assert MINE in tooltip.text_content()
    assert "optimal" in tooltip.text_content()
    assert "gap: 0" in tooltip.text_content()
    assert tooltip.locator("img").count() == 0


@pytest.mark.slow
def test_a_box_and_the_wheel_zoom_and_all_can_be_shown_again(plot):
    """A box and the wheel zoom; all comes back.

    Dragging a box narrows the axes to it; the wheel zooms with Ctrl held.
    """
    page = plot()
    choose(page, "fine", "far")
    x, y = position(page, row(page, "fine", 20))
    before = axes(page)
    page.mouse.move(x - 60, y - 60)
    page.mouse.down()
    page.mouse.move(x, y, steps=4)
    page.mouse.move(x + 50, y + 40, steps=4)
    page.mouse.up()
    boxed = axes(page)
    assert before[0] < boxed[0] < boxed[1] < before[1]

    page.get_by_role("button", name="show all of the plot").click()
    assert axes(page) == pytest.approx(before)

    for control in (False, True):
        page.mouse.move(*position(page, row(page, "fine", 20)))
        if control:
            page.keyboard.down("Control")
        page.mouse.wheel(0, -300 if control else 10)
        page.wait_for_timeout(200)
        left, right, *_ = axes(page)
        assert (before[0] < left < right < before[1]) == control


def drawn_end(page) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Ends in the drawing.

    They are the last point of the solver's path and of the reference, and the target.
    """
    return page.evaluate(
        """() => {
            const last = (name) => document.querySelector(`#attempt-drawer .${name}`)
                .getAttribute("points").trim().split(" ").at(-1).split(",").map(Number);
            const target = document.querySelector("#attempt-drawer circle.target");
            return [last("solver"), last("reference"),
                    ["cx", "cy"].map((name) => Number(target.getAttribute(name)))];
        }"""
    )


def test_a_click_opens_the_path_with_its_numbers(plot):
    """A click opens the path with its numbers.

    The address names the attempt until Escape closes it; `next` shows others at its place.
    """
    page = plot()
    choose(page, "far")
    page.mouse.click(*position(page, row(page, "far", 11)))
    drawer = page.get_by_role("dialog")
    drawer.wait_for()

    names, values = (drawer.locator(part).all_text_contents() for part in ("dt", "dd"))
    facts = dict(zip(names, values, strict=True))
    mine = (one for one in rows() if (one["solver"], one["scenario_id"]) == ("far", "000000b"))
    expected = next(mine)
    assert facts["claim"] == "local"
    assert facts["verdict"] == "optimal"
    assert facts["word"] == expected["word"]
    assert facts["message"] == f"{HOSTILE}\nsecond line"
    assert float(facts["length"].removesuffix(" R")) == pytest.approx(expected["length"], rel=5e-3)
    assert drawer.locator("img").count() == 0
    first = page.url
    assert "#attempt=000000b/0/mine/far/best/cold/default" in first
    assert re.search(r"1 of \d+ here", drawer.text_content())
    drawer.get_by_role("button", name="next").press("Enter")
    assert page.url != first
    drawer.get_by_role("button", name="previous").press("Enter")
    assert page.url == first

    page.keyboard.press("Escape")
    assert not drawer.is_visible()
    assert "#attempt" not in page.url


@pytest.mark.parametrize("solver", [RAW, LONG, "analytic"])
def test_a_drawn_path_is_the_solvers(plot, solver: str):
    """A drawn path ends where its controls lead.

    The paths have a few arcs, and twenty.
    """
    answer = solve(ODD, solver)
    page = plot()
    show(page, row(page, solver, -1))
    path, reference, target = drawn_end(page)
    scale = page.evaluate(
        "() => Number(document.querySelector('#attempt-drawer circle.turning').getAttribute('r'))"
    )
    end = answer.path.end
    # pixels to the right and down, from lengths to the right and up
    expected = (
        target[0] + (end.x - ODD.target_x) / ODD.radius * scale,
        target[1] - (end.y - ODD.target_y) / ODD.radius * scale,
    )

    assert path == pytest.approx(expected, abs=0.3)  # pixels: tenths, and the grid of long paths
    assert math.dist(reference, target) < 0.2


ROUTE = Scenario(target_x=6, target_y=3, via=[(3, 1), (2, 4)], final_heading=2.0, label="route")
POSE = Scenario(target_x=4, target_y=3, final_heading=2.0, label="pose")


@pytest.mark.parametrize("scenario", [ROUTE, POSE], ids=lambda scenario: scenario.label)
def test_via_points_and_a_final_heading_are_drawn(new_tab, tmp_path: FilePath, scenario: Scenario):
    """Via points and a final heading are drawn.

    A path goes astray; the right answer is dashed beside it and passes all that is drawn.
    """
    right = solved(scenario, "analytic")
    wrong = attempt(scenario, "mine", path=Path(scenario.start, [0.0], [3.0]), claim=Claim.LOCAL)
    pair = [right, wrong | {"scenario_id": right["scenario_id"]}]
    page = new_tab(reduced_motion="reduce")
    page.goto(address_of(tmp_path, pair))
    show(page, row(page, "mine", -1))
    _, end, target = drawn_end(page)
    line, dots, arrows = page.evaluate(
        """() => {
            const drawn = document.querySelector("#attempt-drawer svg");
            const pairs = drawn.querySelector(".reference").getAttribute("points").split(" ");
            const dots = [...drawn.querySelectorAll(".via")];
            const place = (dot) => ["cx", "cy"].map((name) => Number(dot.getAttribute(name)));
            const arrows = [...drawn.querySelectorAll("path.target")];
            return [pairs.map((pair) => pair.split(",").map(Number)), dots.map(place),
                    arrows.map((arrow) => arrow.getAttribute("transform"))];
        }"""
    )

    assert math.dist(end, target) < 0.5  # pixels: the grid of long paths
    assert len(dots) == scenario.legs - 1
    for dot in dots:  # a step of the line is a few pixels
        assert min(math.dist(dot, point) for point in line) < 3
    (arrow,) = arrows
    assert arrow.endswith(f"rotate({-math.degrees(2.0):.2f})")


POINTS = [(3.0, 1.0, 1.5), (2.0, 4.0), (-1.0, 2.0)]
TOURS = [
    Scenario(0.5, 0, 0.3, via=POINTS, order="free", closed=True, label="closed"),
    Scenario(0.5, 0, None, via=POINTS, order="free", label="to any from any heading"),
]


@pytest.mark.parametrize("scenario", TOURS, ids=lambda scenario: scenario.label)
def test_a_tour_without_a_target_is_drawn(new_tab, tmp_path: FilePath, scenario: Scenario):
    """A tour without a target is drawn.

    It goes from its own heading through all points; its command says what is asked.
    """
    answer = solved(scenario, "analytic")
    page = new_tab(reduced_motion="reduce")
    page.goto(address_of(tmp_path, [answer]))
    show(page, row(page, "analytic", -1))
    line, dots, targets, arrow = page.evaluate(
        """() => {
            const drawn = document.querySelector("#attempt-drawer svg");
            const pairs = drawn.querySelector(".solver").getAttribute("points").trim().split(" ");
            const place = (dot) => ["cx", "cy"].map((name) => Number(dot.getAttribute(name)));
            return [pairs.map((pair) => pair.split(",").map(Number)),
                    [...drawn.querySelectorAll(".via")].map(place),
                    drawn.querySelectorAll(".target").length,
                    drawn.querySelector("path.start").getAttribute("transform")];
        }"""
    )
    text = page.locator("#attempt-drawer").text_content()
    heading = answer["start_heading"] or answer["heading"]

    assert len(dots) == 3
    for dot in dots:  # a step of the line is a few pixels
        assert min(math.dist(dot, point) for point in line) < 3
    assert targets == 0
    assert arrow.endswith(f"rotate({-math.degrees(heading):.2f})")
    assert ("in any order to the start" if scenario.closed else "to any of them") in text
    expected = solve_command(answer | {"time_limit_s": 30.0})
    assert f"{command_shown(page)} --solver analytic" == expected


def command_shown(page) -> str:
    return page.locator("#attempt-drawer .command code").text_content()


def test_an_address_opens_its_attempt(plot):
    """A link of a hostile name too."""
    page = plot()
    show(page, row(page, MINE, 3))
    link = page.locator("#attempt-drawer a").first.get_attribute("href")
    other = plot(at=link)
    drawer = other.get_by_role("dialog")
    drawer.wait_for()

    assert MINE in drawer.text_content()
    assert "0000003" in link


@pytest.mark.parametrize(
    ("name", "reason"),
    [("nobody/0/knows/this", "holds none"), ("%E0%A4%A", "malformed"), ("", "holds none")],
)
def test_an_address_of_no_attempt_says_so(new_tab, address: str, name: str, reason: str):
    """An address of no attempt says so.

    The sentence of the section goes when a link that holds is followed.
    """
    page = new_tab(reduced_motion="reduce")
    page.goto(f"{address}#attempt={name}")
    problem = page.locator("#attempt-problem")
    page.wait_for_function("document.getElementById('attempt-problem').textContent")

    assert problem.get_attribute("role") == "status"
    assert reason in problem.text_content()
    assert "Expected: an address that “link to this attempt” gives" in problem.text_content()
    assert page.locator("#attempt-drawer").count() == 0
    assert page.locator("section#attempts #attempt-problem").count() == 1
    good = page.evaluate("async () => (await attempts.open()).id(0)")
    page.evaluate("id => { location.hash = `#attempt=${id}`; }", good)
    page.get_by_role("dialog").wait_for()
    assert problem.text_content() == ""

    page.evaluate("name => { location.hash = `#attempt=${name}`; }", name)
    page.wait_for_function("document.getElementById('attempt-problem').textContent")
    assert not page.get_by_role("dialog").is_visible()
    assert reason in problem.text_content()


@pytest.mark.slow
def test_everything_is_reached_by_keyboard(plot):
    """Everything is reached by keyboard.

    The list of points in the frame opens an attempt; closing it leads back to the list.
    """
    page = plot()
    page.locator("details.list summary").press("Enter")
    button = page.locator("table.points button.open").first
    button.press("Enter")
    drawer = page.get_by_role("dialog")
    drawer.wait_for()
    assert drawer.evaluate("node => node.contains(document.activeElement)")
    names = []
    for _ in range(8):
        page.keyboard.press("Tab")
        names.append(page.evaluate("document.activeElement.textContent"))
    assert {"close", "copy", "link to this attempt"} <= set(names)

    page.locator("#attempt-drawer button.close").press("Enter")
    assert button.evaluate("node => node === document.activeElement")


def gallery(page, solver: str):
    """The pictures of a solver's worst attempts."""
    page.get_by_label("solver", exact=True).select_option(
        page.locator(f"#worst-solver option[title={solver}]").get_attribute("value")
    )
    return page.locator("#attempts-worst .card")


def test_the_worst_attempts_of_a_solver_are_drawn(plot):
    """The worst attempts of a solver are drawn.

    Ten paths and references are shown, the largest miss first. Each picture opens the drawer.

    Right answers are nobody's worst.
    """
    page = plot()
    drawn_part(page, "worst")
    assert gallery(page, "fine").count() == 0
    assert page.get_by_text("None of its attempts is wrong.").is_visible()
    cards = gallery(page, "far")
    texts = cards.locator("span:first-of-type").all_text_contents()
    misses = [float(re.search(r"miss ([\d.]+) R", text)[1]) for text in texts]

    assert len(texts) == 10
    assert all("false claim: local, misses" in text for text in texts)
    assert misses == sorted(misses, reverse=True)
    assert cards.locator("svg .solver").count() == cards.locator("svg .reference").count() == 10
    cards.nth(2).press("Enter")
    assert "misses: a false claim" in page.get_by_role("dialog").text_content()


def test_the_plot_opens_with_few_colours_and_shapes(plot, tmp_path: FilePath):
    """The plot opens with three colours at most.

    All shapes and colours differ; a plug-in's solver is one of them.
    """
    mine = "my_solver.py:MySolver"
    records = [one | {"solver": mine} for one in rows() if one["solver"] == "far"]
    page = plot(of=address_of(tmp_path, [*rows(), *records]))
    marks = page.locator("#attempts-plot .marks li")
    looks = page.locator("#attempts-plot .marks path").evaluate_all(
        "paths => paths.map((path) => [path.style.stroke, path.getAttribute('d')])"
    )

    assert "MySolver" in marks.first.text_content()
    assert 2 <= marks.count() <= 3
    for each in zip(*looks, strict=True):
        assert len(set(each)) == len(looks)


def in_a_shell(command: str, programs: FilePath, **options: Any) -> Any:
    """Parsed JSON output of a command.

    The given programs are found before all others.
    """
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-c", command],
        **{"capture_output": True, "text": True, "check": True, "timeout": 120},
        **{"env": os.environ | {"PATH": path}, **options},
    )
    return json.loads(done.stdout)


def command_of(page, attempt_row: int) -> str:
    show(page, attempt_row)
    return command_shown(page)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("solver", "branch"), [("analytic", "best"), ("analytic", "RL"), (RAW, "best"), (LONG, "best")]
)
def test_the_command_repeats_the_attempt(plot, solver: str, branch: str):
    """The command repeats the attempt.

    A shell runs it: it asks the same question, to the last bit, and gets the row's verdict.
    """
    page = plot()
    command = command_of(page, row(page, solver, -1, branch))
    expected = solved(ODD, solver, branch)
    programs = FilePath(sys.executable).parent
    answer = in_a_shell(command.replace(" -- ", " --json -- "), programs)

    assert "--time-limit 30" in command
    for name in ("verdict", "claim", "solver", "branch", "margin", "reference", "length"):
        assert answer[name] == expected[name], name
    # the command shows no gap below 0 of a path that is proved
    assert answer["gap"] in (expected["gap"], max(expected["gap"] or 0.0, 0.0))
    assert answer["travel_time"] == expected["length"] / 1.3


def test_no_name_gets_out_of_its_quotes(plot, tmp_path: FilePath):
    """No name gets out of its quotes.

    A shell hands the solver's name on as one word, and runs nothing that stands in it.
    """
    page = plot()
    command = command_of(page, row(page, MINE, 0))
    program = tmp_path / "dubins-study"
    program.write_text(f"#!{sys.executable}\nimport json, sys\nprint(json.dumps(sys.argv[1:]))\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    words = in_a_shell(command, tmp_path, cwd=tmp_path)

    assert words[words.index("--solver") + 1] == MINE
    assert {entry.name for entry in tmp_path.iterdir()} == {"dubins-study"}


@pytest.mark.slow
def test_the_plot_follows_the_colour_scheme(plot):
    """The plot follows the colour scheme.

    In both schemes its paper and its marks are those of the page.
    """
    page = plot(color_scheme="light")
    colours = """() => {
        const fig = attempts.drawn.figure(), css = getComputedStyle(document.documentElement);
        return [fig.background_fill_color, css.getPropertyValue("--paper").trim(),
                fig.renderers[1].data_source.data.colour.join()];
    }"""
    light = page.evaluate(colours)
    page.emulate_media(color_scheme="dark")
    page.wait_for_function(
        "light => attempts.drawn.figure().background_fill_color !== light", arg=light[0]
    )
    dark = page.evaluate(colours)

    assert light[0] == light[1] != dark[0] == dark[1]
    assert light[2] != dark[2]


@pytest.mark.slow
def test_a_phone_shows_it_all(plot):
    """A phone shows everything.

    Nothing scrolls sideways, with the drawer open too; a tap opens it.
    """
    page = plot(viewport=PHONE, has_touch=True)
    choose(page, "far")
    page.touchscreen.tap(*position(page, row(page, "far", 11)))
    page.get_by_role("dialog").wait_for()

    assert page.evaluate("document.scrollingElement.scrollWidth") <= PHONE["width"]
    picture = page.locator("#attempt-drawer svg").bounding_box()
    assert 0 <= picture["x"] <= picture["x"] + picture["width"] <= PHONE["width"]


@pytest.mark.slow
def test_a_finger_on_the_plot_scrolls_the_page(plot):
    """A finger on the plot scrolls the page.

    A box is drawn by the mouse only: a reader on a phone gets past the plot.
    """
    page = plot(viewport=PHONE, has_touch=True, is_mobile=True)
    canvas = page.locator("#attempts-plot .canvas")
    canvas.evaluate("node => node.scrollIntoView({block: 'center'})")
    box = canvas.bounding_box()
    before = page.evaluate("scrollY")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    finger = page.context.new_cdp_session(page)
    for step in range(12):
        kind = {0: "touchStart", 11: "touchEnd"}.get(step, "touchMove")
        points = [{"x": x, "y": y - 20 * step}] if step < 11 else []
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    page.wait_for_function("before => scrollY > before + 50", arg=before)


FAR = Scenario(target_x=1e12, target_y=-3e11, radius=1e3)
ODD_ROWS = {
    "all failures": [attempt(ODD, "mine", path=None, claim=Claim.FAILED, message="no")],
    "one attempt": [attempt(ODD)],
    "no path exists": [attempt(Scenario(target_x=0, target_y=0.5), branch="LS")],
    "nothing known": [
        attempt(ODD, "mine", path=None, claim=Claim.NONE)
        | dict.fromkeys(
            ("region", "margin", "verdict", "claim", "outcome", "engine", "formulation", "wall_s")
        )
    ],
    "far away": [attempt(FAR, path=Path(FAR.start, [1e-3, 0.0], [1e3, 1e300]), claim=Claim.LOCAL)],
    "no length": [attempt(Scenario(target_x=0, target_y=0), path=Path(ODD.start, [], []))],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ODD_ROWS)
def test_odd_rows_are_shown_too(plot, tmp_path: FilePath, name: str):
    """Odd rows are shown without an error.

    There are the plot, which may be empty, the drawer and the pictures of the worst.
    """
    page = plot(of=address_of(tmp_path, ODD_ROWS[name]))
    page.get_by_label("vertical").select_option("wall_s")
    page.get_by_label("horizontal").select_option("bearing")
    drawn_part(page, "worst")
    cards = page.locator("#attempts-worst .card")
    if name in ("one attempt", "no path exists"):  # they are right
        assert cards.count() == 0
        show(page, 0)
    else:
        cards.first.click()

    command = page.locator("#attempt-drawer .command code").text_content()
    assert str(ODD_ROWS[name][0]["target_x"]).removesuffix(".0") in command
    assert page.locator("#attempt-drawer svg[aria-label]").count() == 1


def test_without_scripts_the_section_says_so(new_tab, address: str):
    """A sentence instead of an empty box."""
    page = new_tab(java_script_enabled=False)
    page.goto(address)
    page.locator("#attempts summary").first.click()

    assert page.get_by_text("This part needs scripts").first.is_visible()
