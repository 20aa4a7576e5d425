"""Sections to figures, tables, Markdown and one self-contained HTML page."""
