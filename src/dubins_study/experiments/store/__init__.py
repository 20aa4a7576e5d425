"""A results folder that loses nothing: parts, manifest, lock, merge, status."""
