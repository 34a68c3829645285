"""Poses in space, as quaternions (REP-103, REP-105)."""

import math
from dataclasses import dataclass

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w of length 1."""


@dataclass(frozen=True, slots=True)
class Transform:
    """The position and the rotation of a frame in another one.

    Attributes:
        translation: The frame's origin, in m.
        rotation: From the frame's axes to those of the other one.
    """

    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def compose(self, other: "Transform") -> "Transform":
        """`other`, given in this frame, in the frame that this one is given in."""
        return Transform(self.apply(other.translation), _normalize(_multiply(self.rotation, other.rotation)))

    def inverse(self) -> "Transform":
        """The transform that undoes this one."""
        x, y, z, w = self.rotation
        back = (-x, -y, -z, w)
        moved = _rotate(back, self.translation)
        return Transform((-moved[0], -moved[1], -moved[2]), back)

    def interpolate(self, other: "Transform", share: float) -> "Transform":
        """Between this one (`share` 0) and `other` (1): straight, and turning at a constant rate."""
        (ax, ay, az), (bx, by, bz) = self.translation, other.translation
        translation = (ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az))
        return Transform(translation, _slerp(self.rotation, other.rotation, share))

    def apply(self, vector: Vector) -> Vector:
        """A point, given in this frame, in the frame that this one is given in."""
        x, y, z = _rotate(self.rotation, vector)
        return (x + self.translation[0], y + self.translation[1], z + self.translation[2])


def turn(axis: Vector, angle: float) -> Quaternion:
    """The rotation about an axis of length 1, by `angle` rad."""
    sin, cos = math.sin(0.5 * angle), math.cos(0.5 * angle)
    return (axis[0] * sin, axis[1] * sin, axis[2] * sin, cos)


def _multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _rotate(rotation: Quaternion, vector: Vector) -> Vector:
    x, y, z, w = rotation
    turned = _multiply(_multiply(rotation, (*vector, 0.0)), (-x, -y, -z, w))
    return turned[:3]


def _normalize(rotation: Quaternion) -> Quaternion:
    norm = math.hypot(*rotation)
    x, y, z, w = rotation
    return (x / norm, y / norm, z / norm, w / norm)


def _slerp(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    cos = sum(p * q for p, q in zip(a, b, strict=True))
    sign = -1.0 if cos < 0.0 else 1.0  # b and -b are one rotation: take the nearer
    angle = math.acos(min(1.0, abs(cos)))
    if angle < 1e-6:
        first, second = 1.0 - share, share
    else:
        first = math.sin((1.0 - share) * angle) / math.sin(angle)
        second = math.sin(share * angle) / math.sin(angle)
    x, y, z, w = (first * p + sign * second * q for p, q in zip(a, b, strict=True))
    return _normalize((x, y, z, w))
