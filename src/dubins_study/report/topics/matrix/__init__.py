"""The topic `matrix` of the report."""
