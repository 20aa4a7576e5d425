"""The topic `solvers` of the report."""
