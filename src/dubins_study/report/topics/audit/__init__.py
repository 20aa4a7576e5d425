"""The topic `audit` of the report."""
