"""Executors turn a plan into judged rows.

They are local workers, or Dask.
"""
