"""The explorer's chart of lengths against the turning radius."""

from __future__ import annotations

from itertools import combinations

import pytest
from browser_tab import DESK, PHONE
from explorer_page import agrees

from dubins_study import Scenario
from dubins_study.study.closed_form.shortest import shortest


@pytest.mark.slow
def test_the_sweep_over_radii_is_the_package_s(explorer):
    """Every word's length at 160 radii, the shortest word, and where the chosen radius stands.

    Problem 5's target enters the left disc at R = 57.35: there LS ends and RL begins.
    """
    page = explorer("0,0,120deg,-80,20,25")
    page.locator(".explorer-more > summary").click()
    page.wait_for_function("window.explorer.sweep.data()")
    data = page.evaluate("window.explorer.sweep.data()")
    assert len(data["radii"]) == 160
    for i, radius in enumerate(data["radii"]):
        scenario = Scenario(0, 0, "120deg", -80, 20, radius)
        best = shortest(scenario)
        assert best is not None
        assert data["best"][i] == best.word
        for branch, lengths in data["lengths"].items():
            optimum = shortest(scenario, branch)
            if optimum is None:
                assert lengths[i] is None
            else:  # no target lies next to an edge
                assert lengths[i] == pytest.approx(optimum.total * radius, rel=1e-12)
    jump = data["best"].index("RL")
    assert data["radii"][jump - 1] < 57.352960 < data["radii"][jump]
    bold = page.locator(".explorer-sweep path.optimal.ls").get_attribute("d")
    assert bold.count("M") == 1
    assert bold.count("L") == jump - 1
    dot = page.locator(".explorer-sweep .start").bounding_box()
    page.locator(".explorer-sweep svg").click(position={"x": 500, "y": 60})
    page.wait_for_function("window.explorer.state().radius !== 25")
    agrees(page)
    moved = page.locator(".explorer-sweep .start")
    page.wait_for_function(
        "x => document.querySelector('.explorer-sweep .start').getBoundingClientRect().x !== x",
        arg=dot["x"],
    )
    plot = page.locator(".explorer-sweep svg").bounding_box()
    box = moved.bounding_box()
    assert box["x"] + box["width"] / 2 - plot["x"] == pytest.approx(500, abs=2)  # three digits of R


def test_big_and_small_numbers_are_short(explorer):
    """Powers of ten without zeros that say nothing: columns and ticks are narrow."""
    texts = explorer().evaluate(
        "[4e6, 1e12, 1.5e9, -2e-7, 1234567, 999999, 999999.9, 0.25]"
        ".map((x) => explorerNumbers.number(x))"
    )

    assert texts == ["4e6", "1e12", "1.5e9", "−2e−7", "1.23457e6", "999999", "1e6", "0.25"]


LABELS = """() => {
  let seed = 7;
  const random = () => { seed = seed * 48271 % 2147483647; return seed / 2147483647; };
  const svg = document.querySelector(".explorer-sweep-plot"), pictures = [];
  document.querySelector(".explorer-more").open = true;
  for (let i = 0; i < 300; i += 1) {
    const far = 10 ** (12 * random() - 4), heading = 6 * random(), bearing = 6 * random();
    const radius = 10 ** (4 * random() - 2);
    const target = {target_x: far * Math.cos(bearing), target_y: far * Math.sin(bearing)};
    if (!window.explorer.set({heading, radius, ...target}, "fit")) throw new Error("refused");
    const best = window.explorer.entries().find((entry) => entry.optimal);
    window.explorer.sweep.draw(window.explorer.state(), best.length);
    const box = (shape) => {
      const {left, right, top, bottom} = shape.getBoundingClientRect();
      return [left, right, top, bottom];
    };
    const texts = svg.querySelectorAll("text:not([visibility=hidden])");
    pictures.push([box(svg), [...texts].map((text) => [text.textContent, ...box(text)])]);
  }
  return pictures;
}"""


@pytest.mark.slow
@pytest.mark.parametrize("viewport", [PHONE, DESK], ids=["phone", "desk"])
def test_no_label_lies_outside_of_the_chart_or_on_another(explorer, viewport):
    """Names and ticks of 300 targets, 1e-4 to 1e8 away at radii of 0.01 to 100."""
    words = 0
    for (left, right, top, bottom), labels in explorer(viewport=viewport).evaluate(LABELS):
        for text, x1, x2, y1, y2 in labels:
            assert left <= x1 < x2 <= right, text
            assert top <= y1 < y2 <= bottom, text
        for (text, x1, x2, y1, y2), (other, u1, u2, v1, v2) in combinations(labels, 2):
            assert x2 <= u1 or u2 <= x1 or y2 <= v1 or v2 <= y1, f"{text} on {other}"
        words += sum(text in ("LS", "RS", "LR", "RL") for text, *_ in labels)

    assert words > 2 * 300  # LS or RS is everywhere, mostly both
