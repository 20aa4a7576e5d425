"""The report: rows to numbers, numbers to tables and figures, and one page. Imports study only."""
