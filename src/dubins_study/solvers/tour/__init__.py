"""Solvers of tours.

Their formulations choose the order of the points and the headings there.
"""
