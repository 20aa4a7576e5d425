"""Solve one question in a process with hard limits.

This room knows nothing of cells or rows.
"""
