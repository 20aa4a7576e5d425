"""The elements of sections.

Content blocks, figure style, solver colours, shared drawings.
"""
