"""The topic `agreement` of the report."""
