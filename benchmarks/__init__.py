"""Speed beside peers, as ratios from one run.

`python -m benchmarks [NAME ...]` runs the benchmarks.
"""
