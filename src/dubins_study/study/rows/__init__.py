"""The results format: the columns of a row, and how steady a machine was."""
