"""The elements of sections: content blocks, figure style, solver colours, shared drawings."""
