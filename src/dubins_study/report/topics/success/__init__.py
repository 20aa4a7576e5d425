"""The topic `success` of the report."""
