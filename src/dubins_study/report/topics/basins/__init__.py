"""The topic `basins` of the report."""
