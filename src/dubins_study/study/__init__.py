"""Define the problem, its exact answer, and its check.

Scenarios, paths, the check and the rows are here. Nothing here knows a solver.
"""
