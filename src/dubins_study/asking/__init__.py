"""Questions put to solvers, timed and judged.

A question is asked alone, or many of them as one frame.
"""
