"""A robot's surroundings: the map, the laser scan and the planned path, in frames that `tf` relates."""
