"""Arguments, options, tables and progress of all commands."""
