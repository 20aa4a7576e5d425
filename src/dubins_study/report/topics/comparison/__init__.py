"""The topic `comparison` of the report."""
