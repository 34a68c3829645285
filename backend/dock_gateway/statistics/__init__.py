"""Statistics of goals."""
