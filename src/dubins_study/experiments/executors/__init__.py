"""Executors turn a plan into judged rows: local workers, Dask, and streamed frames."""
