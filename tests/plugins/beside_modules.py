"""Plug-in that refuses a path with a user's modules.

A user's folder may hold modules of the names of our rooms.
"""

import os
import sys
from pathlib import Path

from dubins_study.solvers.analytic import Analytic


class Plugin(Analytic):
    """The closed form, where neither its folder nor the current one is on `sys.path`."""

    def solve(self, *question):
        assert not {"", ".", os.getcwd(), str(Path(__file__).parent)} & set(sys.path), sys.path  # noqa: PTH109
        return super().solve(*question)
