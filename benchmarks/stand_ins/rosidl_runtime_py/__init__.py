"""Stands in for ROS's package of this name, which no package registry has, where a peer looks up types at its start."""
