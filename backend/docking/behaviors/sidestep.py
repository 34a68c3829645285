"""Finds an edge of the beacon's light: the robot goes round the dock, and must look at it all the time."""

import math

from docking.behaviors.moves import TURN_FIRST, bounded, turn
from docking.core.errors import InfraredLost
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.estimation.beacon_filter import BeaconFilter, Crossing
from docking.goal.behavior import Done, Failed, Step
from docking.parameters import MotionLimits
from docking.parameters.limits import braked

BEARING = 0.45
"""Where the beacon is kept: this part of the way from the center receiver's view to the other one's outer edge."""
STEERING = 2.0
"""How hard the bearing is kept, in 1/s."""
TOUCHING = 0.05
"""From the receivers to the beacon, in m: nearer than that it says nothing more of how fast the bearing changes."""
BEYOND = math.radians(2.0)
"""How far to drive into the dark, and back into the light, to be certain of either, in rad around the dock."""
AGREEMENT = math.radians(2.5)
"""How much the places may differ, in rad around the dock, at which an edge was crossed the same way."""
HYSTERESIS = math.radians(5.0)
"""The same to and fro: late readings, or late odometry, move these apart."""
CROSSINGS = 3
"""How often an edge is crossed before it is believed: out of the light, back into it, and out again."""
TOO_NEAR = 0.6
"""The part of infrared_distance_min at which a robot that drives towards the dock stops, wherever the edge is."""
SILENT = 0.5
"""How old the last reading may be, in s, for the robot to drive on."""


class Sidestep:
    """Drives to and fro in front of the dock, each time further to one side, as a car gets into a parking space.

    Forwards it has the beacon in the one outer receiver, backwards in the other one, so that it never loses sight of
    it but where the light ends. Where it goes out, something may have hidden the beacon. So the robot drives back until
    it sees it again, and once more out of the light: an edge is always at the same place. As it is crossed both ways,
    it does not matter how late readings come.
    """

    def __init__(self, beacon: BeaconFilter, motion: MotionLimits, side: int, lost_after: float) -> None:
        """Begin anywhere in the light.

        Args:
            beacon: Where the beacon is; the edge is noted there.
            motion: Limits of the robot's motion.
            side: 1 to the right, looking at the dock, -1 to the left.
            lost_after: For how long the beacon may be out of sight elsewhere, in s.
        """
        self._beacon = beacon
        self._motion = motion
        self._side = side
        self._lost_after = lost_after
        self._forwards: bool | None = None  # on the way outwards
        self._turning = True
        self._outwards = True
        self._crossings: list[Crossing] = []
        self._handled = beacon.crossings[-1].stamp if beacon.crossings else -math.inf

    def step(self, observation: Observation, dt: float) -> Step:
        """Drive on, until an edge is certain."""
        beacon, odometry = self._beacon, observation.odometry
        if not beacon.known or odometry is None or observation.now - beacon.heard_at > SILENT:
            return STANDSTILL
        for crossing in [crossing for crossing in beacon.crossings if crossing.stamp > self._handled]:
            self._handled = crossing.stamp
            self._take(crossing)
        if len(self._crossings) == CROSSINGS:
            beacon.confirm_edge(self._side, self._edge())
            return Done()
        if self._is_lost(observation.now):
            if observation.now - beacon.seen_at > self._lost_after:
                return Failed(InfraredLost(f"the beacon was out of sight for {self._lost_after:g} s inside its light"))
            return STANDSTILL
        self._choose_way()
        bearing, distance = beacon.bearing(odometry.pose), beacon.distance(odometry.pose)
        velocity = self._drive(bearing, distance, self._motion.with_braking(observation.braking))
        if velocity.linear_x > 0.0 and distance < TOO_NEAR * beacon.receivers.infrared_distance_min:
            return Failed(
                InfraredLost("the robot came close to the dock without finding the edge of the beacon's light")
            )
        return velocity

    def _take(self, crossing: Crossing) -> None:
        """Keep it where it agrees with those before; they are dark, lit, dark."""
        if crossing.lit is self._outwards:
            self._crossings.clear()
        elif not all(_agree(crossing, one) for one in self._crossings):
            self._crossings = [] if crossing.lit else [crossing]
        elif self._crossings or not crossing.lit:
            self._crossings.append(crossing)

    def _beyond(self, line_of_sight: float) -> float:
        """Return how far outside of the last crossing a place is, in rad around the dock."""
        return self._side * normalize_angle(line_of_sight - self._crossings[-1].line_of_sight)

    def _edge(self) -> float:
        out, back, again = (crossing.line_of_sight for crossing in self._crossings)
        return back + 0.5 * normalize_angle(out + 0.5 * normalize_angle(again - out) - back)

    def _is_lost(self, now: float) -> bool:
        """Whether it is dark where it must not be."""
        if self._beacon.lit:
            return False
        if not self._crossings:
            return True
        return not self._outwards and self._beyond(self._beacon.angle) < -(HYSTERESIS + BEYOND)

    def _choose_way(self) -> None:
        if not self._crossings:
            self._outwards = True
            return
        beyond = self._beyond(self._beacon.angle)
        if self._beacon.lit and beyond > HYSTERESIS:
            self._crossings.clear()
            self._outwards = True
        elif self._outwards and not self._beacon.lit and beyond > BEYOND:
            self._outwards = False
        elif not self._outwards and self._beacon.lit and beyond < -BEYOND:
            self._outwards = True

    def _drive(self, bearing: float, distance: float, motion: MotionLimits) -> Velocity:
        receivers = self._beacon.receivers
        nearest, farthest = receivers.infrared_distance_min, receivers.infrared_distance_max
        if self._forwards is None:
            self._forwards = distance > 0.5 * (nearest + farthest)
        elif self._outwards and not self._crossings and (distance < nearest if self._forwards else distance > farthest):
            self._forwards = not self._forwards
            self._turning = True
        kept = receivers.half + BEARING * receivers.infrared_receiver_angle
        wanted = self._side * kept * (1.0 if self._forwards else -1.0)
        error = normalize_angle(bearing - wanted)
        if self._turning and abs(error) > 0.2 * TURN_FIRST:
            return turn(error, motion)
        self._turning = False
        speed = motion.v_linear_max
        if self._forwards is self._outwards:  # towards the dock: it must come to a standstill where it turns back
            room = distance - TOO_NEAR * nearest
            speed = max(motion.v_linear_min, min(speed, braked(max(0.0, room), motion.a_linear_max)))
        else:
            speed = -speed
        keeping = passing_rate(speed, bearing, distance)
        return Velocity(speed, bounded(STEERING * error + keeping, motion.v_angular_max))


def passing_rate(speed: float, bearing: float, distance: float) -> float:
    """Return how fast the bearing of the beacon changes as the robot drives past it.

    Args:
        speed: Of the robot, in m/s.
        bearing: Of the beacon, in rad.
        distance: Between receivers and beacon, in m; may be 0.

    Returns:
        The rate in rad/s, always finite.
    """
    return speed * math.sin(bearing) / max(distance, TOUCHING)


def _agree(one: Crossing, other: Crossing) -> bool:
    """Whether two crossings may be of the same edge."""
    apart = abs(normalize_angle(one.line_of_sight - other.line_of_sight))
    return apart <= (AGREEMENT if one.lit is other.lit else HYSTERESIS)
