"""Files of figures are the same in every run."""

from __future__ import annotations

from matplotlib.layout_engine import ConstrainedLayoutEngine

from dubins_study.report.elements.style import drawing, figure_bytes, fix_layout, new_figure


def test_a_file_does_not_depend_on_the_last_digits_of_the_layout(monkeypatch):
    """They change from run to run: the layout's solver sorts by addresses in memory."""
    layout = ConstrainedLayoutEngine.execute

    def rounded_otherwise(engine, figure):
        layout(engine, figure)
        for part in figure.subfigs:
            part.bbox_relative.set_points(part.bbox_relative.get_points() * (1 + 1e-15))
        for ax in figure.axes:
            left, bottom, width, height = ax.get_position().bounds
            ax.set_position((left, bottom, width * (1 + 1e-15), height))

    files = []
    for execute in (layout, rounded_otherwise):
        monkeypatch.setattr(ConstrainedLayoutEngine, "execute", execute)
        with drawing():
            figure = new_figure(4, 3)
            for part in figure.subfigures(1, 3):
                part.add_subplot().barh([0, 1], [2, 3])
            fix_layout(figure)
            files.append(figure_bytes(figure, "svg"))

    assert files[0] == files[1]
