"""The topic `existence` of the report."""
