"""The letters of a path's word, the branches that a question may ask for, and the formulations."""

from __future__ import annotations

# the rate of each letter: curvature times radius
TURN = {"L": 1.0, "S": 0.0, "R": -1.0}
BRANCHES = ("best", "LS", "RS", "LR", "RL")

# The mathematical problems that are handed to engines, in the order of tables. The joint NLP is the
# paper's model (4.12) with its turns in one order, in the other, or the better of both.
FORMULATIONS = (
    "closed form",
    "one NLP a word",
    "joint NLP, LRS",
    "joint NLP, RLS",
    "joint NLP, both orders",
    "turn rates",
    "Radau collocation",
    "multiple shooting",
    "Pontryagin's system",
    "grid of headings",
    "disjunction",
    "penalty",
)
