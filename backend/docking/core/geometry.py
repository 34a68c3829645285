"""Poses in the plane. Metres and radians; x forward, y left, angles counter-clockwise (REP-103)."""

import math
from dataclasses import dataclass


def normalize_angle(angle: float) -> float:
    """Return an angle between -pi and pi with the same direction."""
    return math.remainder(angle, math.tau)


@dataclass(frozen=True, slots=True)
class Pose:
    """The position and the heading of a frame in another one.

    Attributes:
        x: In m.
        y: In m.
        theta: In rad, counter-clockwise from the other frame's x axis.
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    @property
    def finite(self) -> bool:
        """Whether it is a pose at all: neither NaN nor infinite."""
        return math.isfinite(self.x) and math.isfinite(self.y) and math.isfinite(self.theta)

    def compose(self, other: "Pose") -> "Pose":
        """`other`, given in this pose's frame, in the frame that this pose is given in."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            normalize_angle(self.theta + other.theta),
        )

    def inverse(self) -> "Pose":
        """The pose that undoes this one: `p.inverse().compose(p)` is the origin."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return Pose(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, normalize_angle(-self.theta))

    def relative_to(self, origin: "Pose") -> "Pose":
        """This pose as seen from `origin`, both being given in one frame."""
        return origin.inverse().compose(self)

    def distance_to(self, other: "Pose") -> float:
        """Metres between the two points."""
        return math.hypot(other.x - self.x, other.y - self.y)


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """The turn about z, in rad, of a quaternion as geometry_msgs has it."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def quaternion_of(theta: float) -> tuple[float, float, float, float]:
    """The quaternion (x, y, z, w) of a turn about z by `theta` rad."""
    return (0.0, 0.0, math.sin(theta / 2.0), math.cos(theta / 2.0))
