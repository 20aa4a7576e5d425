"""What an experiment's TOML file may contain.

The messages for invalid files are here too.
"""
