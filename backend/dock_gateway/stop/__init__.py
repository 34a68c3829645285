"""Stopping robots, and releasing the stop."""
