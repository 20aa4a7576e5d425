"""The topic `proofs` of the report."""
