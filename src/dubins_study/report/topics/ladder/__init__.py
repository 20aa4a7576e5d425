"""The topic `ladder` of the report."""
