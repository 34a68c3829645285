"""What is around a robot: the map, the laser scan and the planned path, in frames that `tf` relates."""
