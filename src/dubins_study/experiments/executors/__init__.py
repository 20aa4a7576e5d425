"""Executors turn a plan into judged rows: local workers, or Dask."""
