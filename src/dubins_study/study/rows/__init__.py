"""Results format: columns, manifest and Parquet parts.

The parts have one reader and checker.
"""
