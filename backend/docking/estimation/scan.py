"""Computes the points of a laser scan."""

import math

import numpy as np

from docking.core.geometry import Pose
from robot_io.laser import Points


def place(points: Points, frame: Pose) -> Points:
    """Points of a frame, in the frame that the frame's pose is given in."""
    cos, sin = math.cos(frame.theta), math.sin(frame.theta)
    return np.asarray(points @ np.array(((cos, sin), (-sin, cos))) + (frame.x, frame.y))
