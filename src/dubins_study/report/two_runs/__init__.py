"""Compare two runs, solver by solver.

Which became better or worse, and where.
"""
