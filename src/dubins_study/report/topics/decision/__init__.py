"""The topic `decision` of the report."""
