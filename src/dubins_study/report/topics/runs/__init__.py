"""The topic `runs` of the report."""
