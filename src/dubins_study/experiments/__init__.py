"""Experiments: which questions go to which solvers, and the code that runs and records them."""
