"""Recorded goals: what a robot heard and did, and where the docking server of today would decide otherwise. No ROS."""
