"""The topic `cost` of the report."""
