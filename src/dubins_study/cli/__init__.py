"""The command line: thin commands over the library.

Each command parses, calls the library and prints.
"""
