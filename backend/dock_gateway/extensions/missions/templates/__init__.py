"""Templates: missions with parameters, stored by name."""
