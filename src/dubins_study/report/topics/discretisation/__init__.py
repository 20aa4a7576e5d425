"""The topic `discretisation` of the report."""
