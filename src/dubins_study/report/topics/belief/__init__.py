"""The topic `belief` of the report."""
