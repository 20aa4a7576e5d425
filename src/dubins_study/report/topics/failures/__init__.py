"""The topic `failures` of the report."""
