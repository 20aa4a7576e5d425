"""Compile every loop over rows now.

No later process then waits for it. Numba keeps the machine code beside the modules, in
NUMBA_CACHE_DIR or in the user's cache folder.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.asking.frame import solve_frame
from dubins_study.study.tour.search import compile_tour_loops


def compile_loops() -> None:
    """Run every compiled loop once.

    One leg of each kind is solved and judged by a frame. Then a route and a tour are searched for.
    """
    frame = pd.DataFrame(
        {"x": [0.0], "y": 0.0, "heading": 0.0, "target_x": 3.0, "target_y": 1.0, "radius": 1.0}
    )
    for branch in ("best", "LS"):
        solve_frame(frame, branch=branch)
    for branch in ("best", "LSL"):
        solve_frame(frame.assign(final_heading=1.0), branch=branch)
    compile_tour_loops()


if __name__ == "__main__":
    compile_loops()
