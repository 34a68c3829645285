"""Slows the robot down and stops it before obstacles, and waits until the way is clear."""

import math

import numpy as np

from docking.core.errors import Obstructed, ScanLost
from docking.core.footprint import Footprint
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.core.transform import place
from docking.estimation.clearance import Clearance
from docking.estimation.repetition import RepeatedScan
from docking.parameters import CollisionSettings, ServerSettings
from robot_io.laser import NOWHERE, Points

STARTING = 1.0
"""Seconds in which the first scan may come: ROS finds its publisher first."""
CLEAR_FOR = 0.5
"""Seconds for which the way must be clear before the robot goes on."""
FORGIVEN_AFTER = 2.0
"""After this many seconds without waiting, `obstacle_timeout` starts from zero."""
DOCK_TOLERANCE = 0.05
"""Points up to this far (m) inside the docked robot's edge are still the dock: its pose is known no better."""
BEHIND = tuple(math.radians(angle) for angle in (-30.0, -10.0, 10.0, 30.0))
"""From straight back, in rad: a scan that ends at something in each of these sectors shows what is behind."""


class ObstacleWatch:
    """Looks at the way of each velocity before it is commanded.

    Attributes:
        reason: Why the robot waits, as a sentence; empty while it need not.
        lost: Whether it waits for a scan, not for an obstacle.
    """

    def __init__(self, settings: CollisionSettings, outline: Footprint, *, backward: bool = False) -> None:
        """Begin with a clear way.

        Args:
            settings: When to slow down, to wait and to give up.
            outline: Of the robot, in base_link.
            backward: Whether the dock is behind the docked robot.
        """
        self.reason = ""
        self.lost = False
        self._settings = settings
        self._into_dock = Pose(theta=math.pi if backward else 0.0)  # as seen from the docked robot
        self._front = max(-x if backward else x for x, _ in outline)  # from base_link to the edge at the dock
        self._side = max(abs(y) for _, y in outline)
        self._clearance = Clearance(outline, settings.obstacle_margin)
        self._points = self._around = NOWHERE
        self._hides_dock = False
        self._repeated = RepeatedScan()
        self._blocked: Velocity | None = None  # what could not be commanded
        self._clear_for = 0.0
        self._waited_for = 0.0
        self._free_for = 0.0

    @property
    def timeout(self) -> float:
        """The longest wait, in s."""
        return self._settings.obstacle_timeout

    def check(self, observation: Observation, docked: Pose | None, dt: float) -> bool:
        """Take in the scan, and say whether the robot may move.

        Args:
            observation: Sensor readings, with the robot where it will be when a command takes effect.
            docked: Where base_link stands when docked, in odom; None where that is not known.
            dt: Seconds since the last step.

        Returns:
            Whether the robot may move; `reason` says why not, but is empty while the first scan may yet come.

        Raises:
            Obstructed: It has waited too long, now for an obstacle to go.
            ScanLost: It has waited too long, now for a scan.
        """
        scan, odometry = observation.scan, observation.odometry
        self.lost = scan is None or observation.now - scan.stamp > self._settings.scan_timeout
        repeats = False
        if scan is not None and odometry is not None:
            repeats = self._repeated.check(scan, odometry.pose)
            self._see(scan.points, odometry.pose, docked)
        self.lost |= repeats
        self.reason = ""
        if scan is None and self._waited_for > STARTING:
            self.reason = "no scan received yet: the robot waits"
        elif repeats:
            self.reason = "the scan stays the same although the robot moves: the robot waits"
        elif scan is not None and self.lost:
            self.reason = f"no scan for over {self._settings.scan_timeout:g} s (scan_timeout): the robot waits"
        elif not self.lost and not self._is_clear(dt):
            self.reason = "an obstacle is in the way: the robot waits"
        waits = self.lost or bool(self.reason)
        self._count(waits, dt)
        return not waits

    @property
    def sees_behind(self) -> bool:
        """Whether the last scan shows what is behind the robot: a sector without any point may be out of its view."""
        return not self.lost and _is_behind_seen(self._around)

    def slow_down(self, velocity: Velocity) -> Velocity:
        """The velocity on the same arc at which there is time enough to stop."""
        time = self._clearance.contact(self._points, velocity, self._settings.projection_time)
        return velocity.times(min(1.0, time / self._settings.projection_time))

    def stops(self, velocity: Velocity) -> bool:
        """Whether this velocity must not be commanded; the robot then waits until it may be.

        At zero velocity anything between the robot and its dock counts, because it may hide the dock.
        """
        if not self._hits(velocity):
            return False
        self._blocked, self._clear_for = velocity, 0.0
        return True

    def _hits(self, velocity: Velocity) -> bool:
        if velocity == STANDSTILL:
            return self._hides_dock
        return self._clearance.contact(self._points, velocity, 0.5 * self._settings.projection_time) < math.inf

    def _is_clear(self, dt: float) -> bool:
        if self._blocked is None:
            return True
        self._clear_for = 0.0 if self._hits(self._blocked) else self._clear_for + dt
        if self._clear_for < CLEAR_FOR:
            return False
        self._blocked = None
        return True

    def _count(self, waits: bool, dt: float) -> None:
        if not waits:
            self._free_for += dt
            if self._free_for > FORGIVEN_AFTER:
                self._waited_for = 0.0
            return
        self._waited_for, self._free_for = self._waited_for + dt, 0.0
        if self._waited_for > self._settings.obstacle_timeout:
            waited = f"the robot has waited for {self._settings.obstacle_timeout:g} s (obstacle_timeout)"
            if self.lost:
                raise ScanLost(f"{waited}: there is no scan")
            raise Obstructed(f"{waited}: an obstacle is in the way")

    def _see(self, points: Points, robot: Pose, docked: Pose | None) -> None:
        """Update with the points that are neither the robot nor its dock; note whether one is between the two."""
        points = self._clearance.outside(place(points, robot.inverse()))
        self._points, self._around, self._hides_dock = points, points, False
        if docked is None or not len(points):
            return
        at_dock = place(points, docked.compose(self._into_dock).inverse().compose(robot))
        is_dock = at_dock[:, 0] > self._front - DOCK_TOLERANCE
        distance = robot.distance_to(docked)
        if distance < self._settings.dock_collision_threshold:
            is_dock |= abs(at_dock[:, 1]) > self._side
        self._points = points[~is_dock]
        bearing = math.atan2(docked.y - robot.y, docked.x - robot.x)
        ahead = place(self._points, Pose(theta=robot.theta - bearing))
        between = (ahead[:, 0] > 0.0) & (ahead[:, 0] < distance) & (abs(ahead[:, 1]) < self._side)
        self._hides_dock = bool(between.any())


def _is_behind_seen(points: Points) -> bool:
    """Whether there are points, in base_link, in each sector behind the robot."""
    angles = np.arctan2(-points[:, 1], -points[:, 0])
    return bool(np.all(np.histogram(angles, BEHIND)[0] > 0))


def watch_obstacles(settings: ServerSettings, *, backward: bool = False) -> ObstacleWatch | None:
    """The watch of a new goal; None where the parameters want none.

    Args:
        settings: The parameters.
        backward: Whether the robot docks backwards.
    """
    if not settings.collision.use_collision_detection:
        return None
    return ObstacleWatch(settings.collision, settings.outline.points, backward=backward)
