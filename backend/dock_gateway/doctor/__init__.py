"""Checks the environment, the machine and the ROS graph before a start and on request."""
