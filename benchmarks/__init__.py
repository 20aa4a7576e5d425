"""Speed beside peers, ratios from one run. `python -m benchmarks [NAME ...]`."""
