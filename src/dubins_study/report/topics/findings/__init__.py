"""The topic `findings` of the report."""
