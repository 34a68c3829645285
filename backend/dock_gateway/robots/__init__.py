"""Robots, each a namespace with a battery, a velocity topic and perhaps a simulator."""
