"""The letters of a path's word, and the branches that a question may ask for."""

from __future__ import annotations

# the rate of each letter: curvature times radius
TURN = {"L": 1.0, "S": 0.0, "R": -1.0}
BRANCHES = ("best", "LS", "RS", "LR", "RL")
