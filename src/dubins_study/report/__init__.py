"""The report: turn rows into numbers, tables, figures and one page. Imports only `study`."""
