"""The results format: columns, manifest, and the one reader and checker of Parquet parts."""
