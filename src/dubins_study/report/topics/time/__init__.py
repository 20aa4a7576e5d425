"""The topic `time` of the report."""
