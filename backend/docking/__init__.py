"""Docking for ROS 2: the nodes of the action tutorials, made dependable, and the plain Python they are made of."""
