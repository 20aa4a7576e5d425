"""The files that `dubins-study solve` writes: the drawing and the flight."""

from __future__ import annotations

import sys
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, NamedTuple

from dubins_study.cli.terminal.arguments import CommandError

if TYPE_CHECKING:
    from dubins_study.asking.attempt import Answer
    from dubins_study.missions.flight import Flight
    from dubins_study.missions.mission import Mission


class Files(NamedTuple):
    """What is to be written, and how."""

    plot: FilePath | None
    geojson: FilePath | None
    out: list[FilePath]
    step: float | None  # from waypoint to waypoint, length unit
    altitude: float  # m above home, of points that have none

    @property
    def _named(self) -> list[tuple[str, FilePath]]:
        """Each file with its option."""
        options = [("--plot", self.plot), ("--geojson", self.geojson)]
        options += [("--out", file) for file in self.out]
        return [(option, file) for option, file in options if file is not None]

    def check(self, mission: Mission) -> None:
        """Refuse files that cannot be written, before a solve that takes long."""
        from dubins_study.missions.write import check_flight_file
        from dubins_study.study.values import unwritable

        for option, file in self._named:
            reason = unwritable(file)
            if reason:
                raise CommandError(f"{option}: cannot write {file}: {reason}")
        if self.geojson is not None and self.geojson.suffix.lower() not in (".json", ".geojson"):
            raise CommandError(f"--geojson: {self.geojson}: expected a file .json or .geojson")
        for file in self.out:
            check_flight_file(file, mission)
        if self.plot is not None:
            from dubins_study.report.path_plot import check_format

            check_format(self.plot)

    def write(self, flown: Answer, flight: Flight | None) -> bool:
        """Draw and write a path where files are given; whether none is left out."""
        from dubins_study.missions.write import write_flight

        if flight is None:
            for _, file in self._named:
                message = f"{file} is not written: there is no finite path"
                print(f"dubins-study: {message}", file=sys.stderr)
            return not self._named
        if self.plot is not None:
            from dubins_study.report.path_plot import plot_path

            plot_path(flown, self.plot, names=flight.names, plane=flight.plane)
        for option, file in self._named:
            if option == "--plot":
                continue
            try:
                note = write_flight(flight, file, step=self.step, altitude=self.altitude)
            except OSError as error:
                message = f"{option}: cannot write {file}: {error.strerror}"
                raise CommandError(message) from None
            if note:
                print(f"dubins-study: {note}", file=sys.stderr)
        return True
