"""The topic `scale` of the report."""
