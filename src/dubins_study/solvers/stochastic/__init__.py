"""Search without derivatives: a penalty function of (4.12), an adapter for each engine."""
