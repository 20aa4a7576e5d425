"""The topic `plane` of the report."""
