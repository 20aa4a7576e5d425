"""The topic `convergence` of the report."""
