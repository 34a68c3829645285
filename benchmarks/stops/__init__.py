"""How fast a stop is answered while many are asked for."""
