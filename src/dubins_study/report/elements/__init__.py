"""What sections are built of: content blocks, figure style, solver colours, shared drawings."""
