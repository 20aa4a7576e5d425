"""The topic `map` of the report."""
