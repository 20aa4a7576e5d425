"""The topic `radius` of the report."""
