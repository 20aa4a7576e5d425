"""One question in a process that can be killed; knows nothing of cells or rows."""
