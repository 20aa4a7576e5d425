"""Adapters of engines for nonlinear programs.

The programs come from the formulations.
"""
