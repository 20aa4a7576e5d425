"""The drawing of a flight.

It has names in their places, title, scale and north.
"""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from dubins_study import Scenario, plot_path, solve

ROUTE = Scenario(
    *(0, 0, "30deg", 1500, 200, 80, 20),
    via=[(900, -600), (300, 700)],
    final_heading="90deg",
)


@pytest.fixture(scope="module")
def answer():
    return solve(ROUTE)


def drawn_boxes(figure):
    """Boxes (pixels) of the texts beside points.

    They are named by their texts.
    """
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    texts = [text for text in figure.axes[0].texts if text.get_text()]
    return {text.get_text(): text.get_window_extent(canvas.get_renderer()) for text in texts}


@pytest.mark.parametrize("heading", ["30deg", "120deg", "-90deg", "180deg"])
def test_names_cross_neither_the_path_nor_an_axis_line(heading):
    """Names of few points cross no line.

    The points have room around them.
    """
    asked = Scenario(0, 0, heading, 10, 5, via=[(4, 1), (6, -2)], final_heading="90deg")
    answer = solve(asked)
    figure = plot_path(answer, names=["mill", "oak", "long home"])
    [axes] = figure.axes
    boxes = drawn_boxes(figure)
    path = axes.transData.transform(answer.path.sample(3000)[:, :2])

    assert set(boxes) == {"start", "1 mill", "2 oak", "long home"}
    for box in boxes.values():
        inside = (path > (box.x0, box.y0)) & (path < (box.x1, box.y1))
        assert not inside.all(axis=1).any()
        assert axes.bbox.x0 < box.x0
        assert axes.bbox.y0 < box.y0


def test_the_title_says_what_is_proved_and_the_time(answer):
    """The title says what is proved.

    It has the time where a speed is given, and units where the path lies on Earth.
    """
    titles = [
        plot_path(answer, geographic=geographic).axes[0].get_legend().get_title().get_text()
        for geographic in (False, True)
    ]
    length = f"{answer.length:.2f}"
    time = f"{answer.travel_time:.4g}"

    assert titles[0] == f"analytic: length {length}, proved, time {time}"
    assert titles[1] == f"analytic: length {length} m, proved, time {time} s"


def test_one_leg_is_called_proved_too():
    legend = plot_path(solve(Scenario(target_x=9, target_y=4))).axes[0].get_legend()

    assert legend.get_texts()[0].get_text().endswith(", proved")


def test_on_earth_there_are_a_scale_bar_and_an_arrow_to_the_north(answer):
    """On Earth there are scale bar and north arrow.

    The bar is as long as it says; the arrow points up; without Earth there is neither.
    """
    figure = plot_path(answer, geographic=True)
    boxes = drawn_boxes(figure)
    [axes] = figure.axes
    [bar] = [artist for artist in axes.artists if isinstance(artist, AnchoredSizeBar)]
    line = bar.size_bar.get_children()[0].get_window_extent()
    [north] = [text for text in axes.texts if text.get_text() == "N"]
    metres = np.diff(axes.transData.inverted().transform([line.p0, line.p1])[:, 0])

    assert bar.txt_label.get_text() == "200 m"
    assert metres == pytest.approx([200], rel=1e-3)
    assert boxes["N"].y0 > axes.transAxes.transform(north.xy)[1]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("east (m)", "north (m)")
    [plain] = plot_path(answer).axes
    assert not [artist for artist in plain.artists if isinstance(artist, AnchoredSizeBar)]
    assert (plain.get_xlabel(), plain.get_ylabel()) == ("x", "y")
