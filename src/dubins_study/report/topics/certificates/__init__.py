"""The topic `certificates` of the report."""
