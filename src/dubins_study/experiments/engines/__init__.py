"""Plans in, judged rows out: local workers, Dask, and streamed frames."""
