"""The topic `warm` of the report."""
