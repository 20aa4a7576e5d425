"""What commands share: arguments and options, tables, and progress."""
