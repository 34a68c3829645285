"""Missions: what a robot does, one thing after the other."""
