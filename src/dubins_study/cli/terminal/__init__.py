"""What commands share: their class, completion, examples, tables, progress and verbosity."""
