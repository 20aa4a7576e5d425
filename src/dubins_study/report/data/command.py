"""The columns of a row that define its scenario.

A command line that asks the question again is made from these columns.
"""

from __future__ import annotations

from dubins_study.study.scenario import TOUR, VIA

SCENARIO = ("x", "y", "heading", "target_x", "target_y", "radius")
ROUTE = (*VIA, "final_heading", *TOUR)
