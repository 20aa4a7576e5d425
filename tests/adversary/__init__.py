"""Attacks on the package; `make adversary` makes them whole."""

import os

WHOLE = "WHOLE" in os.environ  # else the slow tests take a part of what takes long
