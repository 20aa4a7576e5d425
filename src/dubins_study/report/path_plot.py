"""One path on its own, for `dubins-study solve --plot`."""

from __future__ import annotations

from pathlib import Path as FilePath

import pandas as pd

from dubins_study.report.elements.figure_file import figure_bytes, fix_layout
from dubins_study.report.elements.style import drawing, new_figure
from dubins_study.report.topics.paper.figures import aspect_of, plot_paths
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

_WIDTH = 5.5  # inches
_HEIGHT = (3.0, 8.0)


def save_path(scenario: Scenario, path: Path, name: str, file: FilePath) -> None:
    """Draw a path with its turning circles, start and target into an SVG, PDF or PNG file.

    Args:
        scenario: where the target is, and how tight the vehicle turns.
        path: what to draw.
        name: what to call it in the legend.
        file: its suffix decides the format.

    Raises:
        OSError: if the file cannot be written.
    """
    paths = pd.DataFrame(
        [
            {
                "branch": path.word(1e-2) or "–",
                "path": path,
                "length": path.total_length,
                "rank": 1,
                "target_x": scenario.target_x,
                "target_y": scenario.target_y,
                "radius": scenario.radius,
            }
        ]
    )
    with drawing():
        height = min(max(_WIDTH * aspect_of(paths) + 0.6, _HEIGHT[0]), _HEIGHT[1])
        figure = new_figure(_WIDTH, height)
        plot_paths(figure.add_subplot(), paths, names=(name,))
        fix_layout(figure)
        file.write_bytes(figure_bytes(figure, file.suffix.removeprefix(".")))
