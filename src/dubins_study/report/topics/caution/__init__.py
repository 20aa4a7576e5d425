"""The topic `caution` of the report."""
