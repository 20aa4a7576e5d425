"""A plug-in that fails as it is imported."""

raise RuntimeError("no licence file")
