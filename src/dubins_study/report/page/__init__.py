"""Write sections as files and as one page.

Figures, tables, Markdown and one self-contained HTML page.
"""
