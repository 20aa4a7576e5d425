"""The topic `bias` of the report."""
