"""An SVG drawing of a part of the plane, in lengths of the plane; the same input, the same text."""

from __future__ import annotations

import math
from collections.abc import Iterable

from markupsafe import Markup

from dubins_study.study.path import Path, rollout

Point = tuple[float, float]


class Canvas:
    """Shapes of the plane as SVG elements, y upwards; later shapes lie over earlier ones.

    Args:
        low: the plane's point at the lower left corner (length unit).
        size: width and height (length unit).
        scale: pixels per length unit.
        label: what the drawing shows, for readers who cannot see it.
        style: CSS for the classes that shapes are given.
        definitions: patterns and markers.
    """

    def __init__(
        self,
        low: Point,
        size: Point,
        scale: float,
        label: str,
        style: str = "",
        definitions: str = "",
    ) -> None:
        self.low, self.scale = low, scale
        self.width, self.height = size[0] * scale, size[1] * scale
        head = Markup(
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" '
            'height="{1}" role="img" aria-label="{2}">'
        )
        self.parts: list[str] = [head.format(_short(self.width), _short(self.height), label)]
        self.parts.append(f"<style>{style}</style><defs>{definitions}</defs>")

    def pixels(self, point: Point) -> Point:
        """The picture's point of a point of the plane."""
        x, y = point
        return (x - self.low[0]) * self.scale, self.height - (y - self.low[1]) * self.scale

    def paper(self, colour: str) -> None:
        """Fill the whole picture, so that it is read on any page."""
        size = f'width="{_short(self.width)}" height="{_short(self.height)}"'
        self.parts.append(f'<rect {size} rx="8" fill="{colour}"/>')

    def circle(self, centre: Point, radius: float, style: str) -> None:
        x, y = map(_short, self.pixels(centre))
        r = _short(radius * self.scale)
        self.parts.append(f'<circle cx="{x}" cy="{y}" r="{r}" class="{style}"/>')

    def dot(self, place: Point, pixels: float, style: str) -> None:
        self.circle(place, pixels / self.scale, style)

    def polygon(self, points: Iterable[Point], style: str) -> None:
        self.parts.append(f'<polygon points="{self._listed(points)}" class="{style}"/>')

    def line(self, first: Point, last: Point, style: str) -> None:
        points = self._listed((first, last))
        self.parts.append(f'<polyline points="{points}" class="{style}"/>')

    def path(self, path: Path, style: str) -> None:
        """Arcs and straights exactly; arcs in two halves, so that none is a full circle."""
        halves = path.length.repeat(2) / 2
        rates = path.curvature.repeat(2)
        poses = rollout(path.start, rates, halves).tolist()
        x, y = map(_short, self.pixels((poses[0][0], poses[0][1])))
        text = f"M{x} {y}"
        for (px, py, _), k in zip(poses[1:], rates.tolist(), strict=True):
            x, y = map(_short, self.pixels((px, py)))
            if k == 0:
                text += f"L{x} {y}"
            else:
                r, sweep = _short(self.scale / abs(k)), 0 if k > 0 else 1
                text += f"A{r} {r} 0 0 {sweep} {x} {y}"
        self.parts.append(f'<path d="{text}" class="{style}"/>')

    def arrow(self, tail: Point, heading: float, pixels: float, style: str) -> None:
        """A straight arrow with a filled head, of a length in pixels."""
        cos, sin, unit = math.cos(heading), math.sin(heading), 1 / self.scale
        x, y = tail

        def at(along: float, across: float) -> Point:
            forward, left = along * unit, across * unit
            return x + forward * cos - left * sin, y + forward * sin + left * cos

        self.line(tail, at(pixels - 9, 0), style)
        self.polygon((at(pixels, 0), at(pixels - 12, 5), at(pixels - 12, -5)), f"{style} head")

    def text(
        self, place: Point, text: str, style: str, shift: Point = (0, 0), anchor: str = "start"
    ) -> None:
        """A text at a point of the plane, moved by pixels to the right and downwards."""
        x, y = self.pixels(place)
        x, y = x + shift[0], y + shift[1]
        attributes = f'x="{_short(x)}" y="{_short(y)}" class="{style}" text-anchor="{anchor}"'
        self.parts.append(f"<text {attributes}>{Markup.escape(text)}</text>")

    def svg(self) -> str:
        """The whole drawing."""
        return "\n".join([*self.parts, "</svg>"]) + "\n"

    def _listed(self, points: Iterable[Point]) -> str:
        pairs = (map(_short, self.pixels(point)) for point in points)
        return " ".join(f"{x},{y}" for x, y in pairs)


def _short(pixels: float) -> str:
    """A hundredth of a pixel is enough; the same text on every machine."""
    return f"{round(pixels, 2) + 0.0:.2f}".rstrip("0").rstrip(".")
