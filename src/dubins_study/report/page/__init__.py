"""Write sections as figures, tables, Markdown and one self-contained HTML page."""
