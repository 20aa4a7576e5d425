"""The topic `summary` of the report."""
