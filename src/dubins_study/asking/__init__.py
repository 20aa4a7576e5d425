"""Questions put to solvers, timed, and judged.

One question is asked at a time, or a frame of them.
"""
