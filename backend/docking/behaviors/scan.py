"""Turns to and fro in front of the beacon, to learn its direction from the edges of the receivers' views."""

import math

from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.estimation.beacon_filter import BeaconFilter
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

BEYOND = math.radians(5.0)
"""How far beyond the edge of the center receiver's view to turn, in rad: the width of two readings."""


class Scan:
    """To the left, to the right, and back to the middle."""

    def __init__(self, beacon: BeaconFilter, motion: MotionLimits) -> None:
        """Start at the current pose of the robot.

        Args:
            beacon: Where the beacon is, if that is known.
            motion: Limits of the robot's motion.
        """
        self._beacon = beacon
        self._speed = max(motion.v_angular_min, min(beacon.receivers.infrared_scan_speed, motion.v_angular_max))
        reach = beacon.receivers.half + BEYOND
        self._bearings = [-reach, reach, 0.0]

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn until the beacon has the next bearing."""
        odometry = observation.odometry
        if not self._beacon.known or odometry is None:
            return STANDSTILL
        error = self._beacon.bearing(odometry.pose) - self._bearings[0]
        if abs(error) < 0.5 * self._speed * max(dt, 0.05) + 0.01:
            self._bearings.pop(0)
            if not self._bearings:
                return Done()
            error = self._beacon.bearing(odometry.pose) - self._bearings[0]
        return Velocity(0.0, math.copysign(self._speed, error))
