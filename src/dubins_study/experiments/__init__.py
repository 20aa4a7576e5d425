"""Experiments: their questions, their runs and their rows.

An experiment says which questions go to which solvers; the code here runs and records them.
"""
