"""Helpers for tests of the real thing: ROS domains of their own, processes that end."""
