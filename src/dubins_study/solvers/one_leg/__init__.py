"""The paper's model (4.12) of one leg.

Its cases, its initial guesses, and the polishing of its points.
"""
