"""The files that `dubins-study solve` writes.

They are the drawing and the flight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, NamedTuple

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import CommandError

_DRAWN_BY = ("matplotlib", "pandas", "pyarrow")  # packages that a drawing needs

if TYPE_CHECKING:
    from dubins_study.missions.flight import Flight
    from dubins_study.missions.mission import Mission


class Files(NamedTuple):
    """The files to write, with their settings."""

    plot: FilePath | None
    geojson: FilePath | None
    out: list[FilePath]
    step: float | None  # from waypoint to waypoint, length unit
    altitude: float  # m above home, of points that have none

    @property
    def _named(self) -> list[tuple[str, FilePath]]:
        """Pairs (option, file) of all files that are given."""
        options = [("--plot", self.plot), ("--geojson", self.geojson)]
        options += [("--out", file) for file in self.out]
        return [(option, file) for option, file in options if file is not None]

    def check(self, mission: Mission, read: Sequence[object]) -> None:
        """Refuse files that cannot be written.

        This is done before the solve, which may take long. Files in `read`, from which the question
        was read, must not be overwritten; other values in it are ignored.
        """
        from dubins_study.missions.write import format_of
        from dubins_study.study.values import unwritable

        if not (self.step is None or 0 < self.step < math.inf):
            raise CommandError(f"--step is {self.step}; expected a length above 0")
        if not math.isfinite(self.altitude):
            raise CommandError(f"--altitude is {self.altitude}; expected a number")
        in_use = {file.resolve() for file in read if isinstance(file, FilePath)}
        for option, file in self._named:
            reason = unwritable(file)
            if reason:
                raise CommandError(f"{option}: cannot write {file}: {reason}")
            if file.resolve() in in_use:
                raise CommandError(f"{option}: {file} is read, or is written twice")
            in_use.add(file.resolve())
        if self.geojson is not None and self.geojson.suffix.lower() not in (".json", ".geojson"):
            raise CommandError(f"--geojson: {self.geojson}: expected a file .json or .geojson")
        for file in self.out:
            format_of(file, mission)
        if self.plot is not None:
            from dubins_study.solvers.setting_checks import missing_package

            reason = missing_package(*_DRAWN_BY)
            if reason:
                raise CommandError(f"--plot: {reason}; pip install {' '.join(_DRAWN_BY)}")
            from dubins_study.report.path_plot import check_format

            check_format(self.plot)

    def write(self, flight: Flight | None, names: Sequence[str]) -> bool:
        """Draw and write a path to the files.

        Return whether no file is left out.
        """
        lacks: dict[str, list[str]] = {}  # what a format cannot say -> the files in such a format
        left_out = False
        for option, file in self._named:
            reason = _unwritten(option, flight)
            if flight is None or reason:
                output.note(f"{file} is not written: {reason}")
                left_out = True
                continue
            lack = self._write(option, file, flight, names)
            if lack:
                lacks.setdefault(lack, []).append(str(file))
        if self.out and flight is not None and flight.answer.proof != "proved":
            output.note("the flight is not proved to be the shortest; --time-limit gives more time")
        for lack, files in lacks.items():
            output.note(f"{', '.join(files)}: {lack}")
        return not left_out

    def _write(self, option: str, file: FilePath, flight: Flight, names: Sequence[str]) -> str:
        """Write one file; return what its format cannot say."""
        from dubins_study.missions.write import write_flight

        if option == "--plot":
            from dubins_study.report.path_plot import plot_path

            plot_path(flight.answer, file, names=names, geographic=flight.mission.plane is not None)
            return ""
        try:
            return write_flight(flight, file, step=self.step, altitude=self.altitude)
        except OSError as error:
            raise CommandError(f"{option}: cannot write {file}: {error.strerror}") from None


def _unwritten(option: str, flight: Flight | None) -> str:
    """Why a file is not written, or empty."""
    if flight is None:
        return "there is no finite path"
    if option == "--out" and not flight.arrives:
        return "the path does not arrive"
    return ""
