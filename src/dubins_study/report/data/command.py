"""The columns that ask a row's question again."""

from __future__ import annotations

from dubins_study.study.scenario import TOUR, VIA

SCENARIO = ("x", "y", "heading", "target_x", "target_y", "radius")
ROUTE = (*VIA, "final_heading", *TOUR)
