"""The topic `paper` of the report."""
