"""Finds the edge of the beacon's light: the robot goes round the dock, and must look at it all the time."""

import math

from docking.behaviors.moves import TURN_FIRST, bounded, turn
from docking.core.errors import InfraredLost
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.estimation.beacon_filter import BeaconFilter
from docking.goal.behavior import Done, Failed, Step
from docking.parameters import MotionLimits

NEAREST = 0.35
"""From the receivers to the beacon, in m, where forwards becomes backwards."""
FARTHEST = 1.0
"""From the receivers to the beacon, in m, where backwards becomes forwards."""
STEERING = 2.5
"""How hard the bearing is kept, in 1/s."""
TOUCHING = 0.05
"""From the receivers to the beacon, in m: nearer than that it says nothing more of how fast the bearing changes."""
GONE = 3
"""Readings, one after another, that must not see the beacon to be beyond the edge."""
SILENT = 0.5
"""How old the last reading may be, in s, for the robot to drive on."""
SPEED = 0.8
"""The part of the highest speed that it drives with."""


class Sidestep:
    """Drives to and fro in front of the dock, each time further to one side, as a car gets into a parking space.

    Forwards it has the beacon in the one outer receiver, backwards in the other one, so that it never loses sight of
    it but where the light ends.
    """

    def __init__(self, beacon: BeaconFilter, motion: MotionLimits, side: int) -> None:
        """Begin anywhere in the light.

        Args:
            beacon: Where the beacon is; the edge is noted there.
            motion: What the robot may do.
            side: 1 to the right, looking at the dock, -1 to the left.
        """
        self._beacon = beacon
        self._motion = motion
        self._side = side
        self._count = beacon.count
        self._forwards: bool | None = None
        self._turning = True

    def step(self, observation: Observation, dt: float) -> Step:
        """Drive on, until the light ends."""
        beacon, odometry = self._beacon, observation.odometry
        if beacon.position is None or odometry is None:
            return STANDSTILL
        if beacon.dark >= GONE and beacon.lit is not None:
            if beacon.count == self._count:
                return Failed(InfraredLost("the beacon went out of sight before the robot had moved"))
            beacon.edges[self._side] = beacon.lit
            return Done()
        if observation.now - beacon.heard_at > SILENT:
            return STANDSTILL
        robot = odometry.pose
        distance = beacon.receivers.position(robot).distance_to(beacon.position)
        if self._forwards is None:
            self._forwards = distance > 0.5 * (NEAREST + FARTHEST)
        elif distance < NEAREST if self._forwards else distance > FARTHEST:
            self._forwards = not self._forwards
            self._turning = True
        return self._drive(beacon.bearing(robot), distance)

    def _drive(self, bearing: float, distance: float) -> Velocity:
        wanted = self._side * self._beacon.receivers.infrared_receiver_angle * (1.0 if self._forwards else -1.0)
        error = normalize_angle(bearing - wanted)
        if self._turning and abs(error) > 0.2 * TURN_FIRST:
            return turn(error, self._motion)
        self._turning = False
        speed = SPEED * self._motion.v_linear_max * (1.0 if self._forwards else -1.0)
        keeping = speed * math.sin(bearing) / max(distance, TOUCHING)  # as the beacon goes by
        return Velocity(speed, bounded(STEERING * error + keeping, self._motion.v_angular_max))
