"""Colours and markers of solvers.

They have contrast on both pages, distance for every reader, and a rule for plug-ins.
"""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from dubins_study.report import page
from dubins_study.report.elements import style
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import ENGINE_HUES, HUES, INK, VARIABLES, css_values
from dubins_study.report.topics import basins, ladder, plane
from dubins_study.report.topics.routes import GAPS
from dubins_study.study.scenario import Scenario
from tests.unit.report.results_folder import attempt

# Linear light as seen without one kind of cones: Machado, Oliveira and Fernandes 2009, "A
# physiologically-based model for simulation of color vision deficiency", severity 1.
SIGHTS = {
    "trichromacy": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
}
# Distances in OKLab. 0.02 is just noticeable for neighbouring patches (Ottosson 2020 gives the
# space); thin lines apart from each other need several times that.
LEAST_DISTANCE = {"trichromacy": 0.1, "protanopia": 0.07, "deuteranopia": 0.07}
LEAST_CONTRAST = 3.0  # WCAG 2.2, 1.4.11
MODES = ("light", "dark")
GREY = np.array([0.2126, 0.7152, 0.0722])  # luminance of linear light


def paper_of(mode):
    """The page's background in a mode.

    It is read from the style sheet.
    """
    folder = Path(page.__file__).parent / "templates"
    sheets = sorted(folder.rglob("*.css"))
    papers = re.findall(r"--paper: (#[0-9a-f]{6})", "".join(s.read_text("utf-8") for s in sheets))
    return papers[MODES.index(mode)]


def linear(colour):
    """Linear light of `#rrggbb`, shape (3,) (IEC 61966-2-1)."""
    values = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def contrast(first, second):
    """The contrast ratio of WCAG 2.2."""
    light, dark = sorted((linear(c) @ GREY + 0.05 for c in (first, second)), reverse=True)
    return light / dark


def oklab(light):
    """OKLab of linear light.

    Ottosson 2020, "A perceptual color space for image processing".
    """
    cones = np.array(
        [
            [0.4122214708, 0.5363325363, 0.0514459929],
            [0.2119034982, 0.6806995451, 0.1073969566],
            [0.0883024619, 0.2817188376, 0.6299787005],
        ]
    )
    lab = np.array(
        [
            [0.2104542553, 0.7936177850, -0.0040720468],
            [1.9779984951, -2.4285922050, 0.4505937099],
            [0.0259040371, 0.7827717662, -0.8086757660],
        ]
    )
    return lab @ np.cbrt(cones @ light)


def test_the_measures_agree_with_published_values():
    """The measures agree with published values.

    White on black is 21 to 1; OKLab of white and of pure red is as its author prints it.
    """
    assert contrast("#ffffff", "#000000") == pytest.approx(21)
    assert oklab(linear("#ffffff")) == pytest.approx([1, 0, 0], abs=1e-6)
    assert oklab(linear("#ff0000")) == pytest.approx([0.6280, 0.2249, 0.1258], abs=1e-4)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", [*HUES, *range(len(ENGINE_HUES))])
def test_every_hue_has_contrast_on_its_page(name, mode):
    """Every hue has contrast on its page.

    Graphical objects need 3 to 1, on the background that the style sheet states.
    """
    hue = HUES[name] if isinstance(name, str) else ENGINE_HUES[name]

    assert contrast(getattr(hue, mode), paper_of(mode)) >= LEAST_CONTRAST


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("sight", SIGHTS)
def test_engines_differ_for_every_reader(sight, mode):
    """Engines differ for every reader.

    In either mode no two engines' hues look alike, red-green blindness included.
    """
    seen = [oklab(np.clip(SIGHTS[sight] @ linear(getattr(hue, mode)), 0, 1)) for hue in ENGINE_HUES]
    distances = [np.linalg.norm(a - b) for a, b in combinations(seen, 2)]

    assert min(distances) >= LEAST_DISTANCE[sight]


@pytest.mark.parametrize(
    "marks", [plane.WORDS, plane.ANSWERS, ladder.MARKS, basins.MARKS, [*GAPS.values()]]
)
def test_kinds_of_a_map_differ_in_grey_print(marks):
    """Kinds of a map differ in grey print.

    They differ by their marker, or by a twentieth of the range from black to white, as it is seen.
    """
    for one, other in combinations(marks, 2):
        greys = [oklab(np.full(3, linear(mark.colour) @ GREY))[0] for mark in (one, other)]
        assert one.marker != other.marker or abs(greys[0] - greys[1]) > 0.05, (one.key, other.key)


def test_every_colour_of_a_figure_has_one_variable():
    """Every colour of a figure has one variable.

    Two kinds that share a value on the light page could not differ on the dark one.
    """
    lights = [hue.light for hue in (*HUES.values(), *ENGINE_HUES)]
    fixed = {style.INK, style.MUTED, style.RULE, style.PAPER, style.ON_MAP, style.MAP_PAPER}

    assert len(VARIABLES) == len(lights) == len(set(lights) - fixed)


@pytest.mark.parametrize("mode", MODES)
def test_the_style_sheet_declares_what_figures_use(mode):
    """Each variable once, with its value in that mode."""
    declared = dict(re.findall(r"(--[\w-]+): (#[0-9a-f]{6});", css_values(mode)))

    assert set(declared) == set(VARIABLES.values())
    assert len(set(declared.values())) == len(declared)


SPECS = ["slsqp", "analytic", "turn-rate-qp[n=50]", "turn-rate-qp", "ipopt", "my-plugin[a=1]"]


def test_solvers_differ_in_marker_and_variants_in_line():
    """Solvers differ in marker, variants in line.

    What grey print keeps tells them apart; variants share their solver's hue.
    """
    looks = Palette.of(SPECS).looks(SPECS)
    plain, variant = looks["turn-rate-qp"], looks["turn-rate-qp[n=50]"]

    assert (plain.colour, plain.marker) == (variant.colour, variant.marker)
    assert plain.line != variant.line
    assert looks["analytic"].colour == INK
    assert len({look.marker for look in looks.values()}) == 5  # names


def test_many_plug_ins_differ():
    """Many plug-ins differ.

    Hue and marker together repeat only where nobody could tell more apart.
    """
    specs = [f"solver-{i}" for i in range(40)]
    looks = Palette.of(specs).looks(specs)

    assert len({(look.colour, look.marker) for look in looks.values()}) == 40


def test_a_page_draws_a_solver_as_its_engine(load_rows):
    """A page draws a solver as its engine.

    Another page with other solvers, or rows in another order, draws the engine alike.
    """
    scenario = Scenario(0, 0, 0, 4, 1)
    specs = {"nlp[engine=alpaqa]": "alpaqa", "collocation[n=9]": "Ipopt", "mine": "my engine"}
    rows = [attempt(scenario, spec, engine=engine) for spec, engine in specs.items()]
    palette = Palette.of_page(load_rows("some", rows))
    other = Palette.of_page(load_rows("other", rows[:1]))
    assert Palette.of_page(load_rows("turned", rows[::-1])).hues == palette.hues
    looks = palette.looks(specs)

    for spec, engine in specs.items():
        assert (looks[spec].colour, looks[spec].marker) == palette.hues[engine]
    assert len({palette.hues[engine] for engine in specs.values()}) == len(specs)
    assert other.hues["alpaqa"] == palette.hues["alpaqa"]
