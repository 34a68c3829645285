"""A robot, its battery and its dock, simulated: plain Python without ROS, the same again for the same seed.

Frames: `world`, whose origin is the dock's marker, x into the dock; `odom` and `base_link` as everywhere in docking.
"""
