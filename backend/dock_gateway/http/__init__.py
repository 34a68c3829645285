"""HTTP: what every route needs, and nothing of a feature."""
