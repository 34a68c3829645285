"""The poses of a robot and its dock, combined from several frames. Plain data and geometry.

Metres and radians; x forward, y left, angles counter-clockwise (REP-103). Where the simulator publishes the true pose,
everything is given in its frame `world`, else in `odom` (REP-105).
"""

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, NamedTuple

WORLD, ODOM, BASE = "world", "odom", "base_link"
# Frames that a footprint may be given in.
FOOTPRINT_FRAMES = (BASE, "base_footprint", "")

# Seconds for which a marker or a range is valid.
SEEN_FOR = 0.5
# Seconds for which the docking server's data about the dock is valid; it publishes while a goal runs.
KNOWN_FOR = 1.5
# Seconds for which a robot's pose is valid.
PLACED_FOR = 1.0
# Metres from the origin: map projections count to 10,000 km. A pose beyond is none.
FARTHEST = 1e8
# Lengths of a quaternion that can be meant as a rotation; all zeros is one that was never set.
MIN_LENGTH, MAX_LENGTH = 0.1, 10.0
# Metres: an infrared receiver does not see farther (REP-117: infinite).
MAX_RANGE = 1000.0
# Seconds between two poses of the same moment.
AT_ONCE = 0.015
# Number of poses kept, to relate an observation to the robot's pose at that time.
REMEMBERED = 60


class Pose(NamedTuple):
    """The pose of a frame in another one."""

    x: float
    y: float
    theta: float

    @classmethod
    def in_plane(cls, x: float, y: float, turn: tuple[float, float, float, float]) -> "Pose":
        """Return the pose of a position in metres and a quaternion (x, y, z, w), which need not be of length 1.

        Raises:
            ValueError: It cannot be right; the error says why.
        """
        if not all(abs(value) <= FARTHEST for value in (x, y)):  # nor does a NaN
            raise ValueError(f"its position is ({x:g}, {y:g}), not within {FARTHEST:g} m")
        if not MIN_LENGTH <= math.hypot(*turn) <= MAX_LENGTH:
            raise ValueError(f"its orientation is ({', '.join(f'{part:g}' for part in turn)}), which is no rotation")
        i, j, k, w = turn
        return cls(x, y, math.atan2(2 * (w * k + i * j), w**2 + i**2 - j**2 - k**2))

    def compose(self, other: "Pose") -> "Pose":
        """Transform `other` from this pose's frame to the frame that this pose is given in."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            math.remainder(self.theta + other.theta, math.tau),
        )

    def inverse(self) -> "Pose":
        """Return the inverse transform."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, -self.theta)

    def document(self) -> dict[str, float]:
        """Return the pose for JSON, rounded to 0.1 mm and 0.006 degrees."""
        return {"x": round(self.x, 4), "y": round(self.y, 4), "theta": round(self.theta, 4)}


@dataclass(frozen=True)
class SeenPose:
    """A pose that was observed or reported: its frame, its own stamp, and when it was received, in seconds."""

    pose: Pose
    frame: str
    stamp: float
    heard_at: float


class Track:
    """The robot's recent poses in one frame."""

    def __init__(self) -> None:
        self._poses: deque[SeenPose] = deque(maxlen=REMEMBERED)

    def add(self, seen: SeenPose) -> None:
        """Add a newer pose. A stamp that steps back means that the robot restarted, so older poses are dropped."""
        if self._poses and seen.stamp < self._poses[-1].stamp:
            self._poses.clear()
        self._poses.append(seen)

    def latest(self, now: float) -> SeenPose | None:
        """Return the newest pose, or None if it is too old."""
        if not self._poses or now - self._poses[-1].heard_at > PLACED_FOR:
            return None
        return self._poses[-1]

    def near(self, stamp: float) -> SeenPose | None:
        """Return the pose nearest to a stamp."""
        return min(self._poses, key=lambda seen: abs(seen.stamp - stamp), default=None)


class Scene:
    """The known poses of one robot. Times are seconds. `now` and `heard_at` share a clock; stamps use another."""

    def __init__(self) -> None:
        self._tracks = {ODOM: Track(), WORLD: Track()}
        self._world_from_odom: Pose | None = None
        self._dock: Pose | None = None
        self._said: dict[str, SeenPose] = {}
        self._ranges: dict[str, tuple[float | None, float]] = {}
        self._footprint: dict[str, Any] | None = None

    def place(self, seen: SeenPose) -> None:
        """Add the robot's pose, from odometry or the true one, depending on its frame."""
        track, other = (WORLD, ODOM) if seen.frame == WORLD else (ODOM, WORLD)
        self._tracks[track].add(seen)
        newest = self._tracks[other].latest(seen.heard_at)
        if newest is None:
            self._world_from_odom = None
            return
        # Both tracks cover the same times, and either may be ahead.
        stamp = min(seen.stamp, newest.stamp)
        believed, true = self._tracks[ODOM].near(stamp), self._tracks[WORLD].near(stamp)
        if believed and true and (abs(believed.stamp - true.stamp) <= AT_ONCE or self._world_from_odom is None):
            self._world_from_odom = true.pose.compose(believed.pose.inverse())

    def say(self, name: str, seen: SeenPose) -> None:
        """Store an observed or planned pose: `marker`, `docked`, `staging`."""
        self._said[name] = seen

    def set_dock(self, dock: Pose) -> None:
        """Store the true pose of the dock's face."""
        self._dock = dock

    def set_footprint(self, footprint: dict[str, Any]) -> None:
        """Store the robot's outline, as `footprint_document` returns it."""
        self._footprint = footprint

    def set_range(self, receiver: str, distance: float, heard_at: float) -> None:
        """Store an infrared receiver's range (`left`, `center`, `right`) in metres; infinite if too far (REP-117).

        What cannot be right, such as NaN or a negative range, is none, too.
        """
        self._ranges[receiver] = (distance if 0.0 <= distance <= MAX_RANGE else None, heard_at)

    def document(self, now: float) -> dict[str, Any] | None:
        """Return the scene for JSON, in one frame, or None if the robot's pose is not known."""
        truth, odometry = self._tracks[WORLD].latest(now), self._tracks[ODOM].latest(now)
        robot = truth or odometry
        if robot is None:
            return None
        frame = ODOM if truth is None else WORLD
        return {
            "frame": frame,
            "robot": robot.pose.document(),
            "odom": self._odom(frame),
            "dock": self._dock.document() if self._dock and frame == WORLD else None,
            "docked": self._in(frame, "docked", now, KNOWN_FOR),
            "staging": self._in(frame, "staging", now, KNOWN_FOR),
            "marker": self._in(frame, "marker", now, SEEN_FOR),
            "infrared": self._infrared(now),
            "footprint": self._footprint,
        }

    def _in(self, frame: str, name: str, now: float, known_for: float) -> dict[str, float] | None:
        seen = self._said.get(name)
        if seen is None or now - seen.heard_at > known_for:
            return None
        origin = self._origin(seen, frame)
        return None if origin is None else origin.compose(seen.pose).document()

    def _origin(self, seen: SeenPose, frame: str) -> Pose | None:
        """Return the pose of an observation's frame in `frame`, or None if no transform is known."""
        if seen.frame == frame:
            return Pose(0.0, 0.0, 0.0)
        if seen.frame == BASE:
            robot = self._tracks[frame].near(seen.stamp)
            return None if robot is None else robot.pose
        return self._world_from_odom if seen.frame == ODOM else None

    def _odom(self, frame: str) -> dict[str, float] | None:
        """Return where odometry began; None if that is unknown."""
        origin = Pose(0.0, 0.0, 0.0) if frame == ODOM else self._world_from_odom
        return None if origin is None else origin.document()

    def _infrared(self, now: float) -> dict[str, float | None] | None:
        fresh = {name: distance for name, (distance, at) in self._ranges.items() if now - at <= SEEN_FOR}
        if not fresh:
            return None
        return {name: _rounded(fresh.get(name)) for name in ("left", "center", "right")}


def _rounded(distance: float | None) -> float | None:
    return None if distance is None else round(distance, 4)


class EvenRate:
    """Rate limit with even spacing.

    Args:
        rate_hz: Maximum rate, in Hz.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period = 1 / rate_hz
        self._due = float("-inf")

    def due(self, now: float) -> bool:
        """Return whether the next one is due. If so, it counts as sent."""
        if now < self._due:
            return False
        self._due = max(self._due, now - self._period) + self._period
        return True
