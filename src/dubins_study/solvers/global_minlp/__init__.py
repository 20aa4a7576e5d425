"""Global solvers: (4.12), or a disjunction of words.

They prove a bound on the shortest length.
"""
