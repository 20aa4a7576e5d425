"""A results folder that loses nothing: written part by part, locked, mended, merged, counted."""
