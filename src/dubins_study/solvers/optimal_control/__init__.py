"""Solvers of the optimal-control problem (2.2).

They use turn rates, multiple shooting and Radau collocation.
"""
