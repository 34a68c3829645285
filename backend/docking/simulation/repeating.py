"""Sensors whose driver repeats what it measured before, with new stamps."""

from typing import Generic, TypeVar

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity

Item = TypeVar("Item")


class Freezer(Generic[Item]):
    """Repeats the last measurement while it is frozen."""

    __slots__ = ("_last",)

    def __init__(self) -> None:
        self._last: Item | None = None

    def pass_on(self, item: Item, *, frozen: bool) -> Item:
        """Return the measurement to send: the current one, or the last from before it froze."""
        if not frozen or self._last is None:
            self._last = item
        return self._last


class DetectorFaults:
    """A detector that repeats its last image, goes on with the last motion, or smooths its detections."""

    __slots__ = ("_frozen_at", "_last", "_smooth", "_velocity")

    def __init__(self) -> None:
        self._last: list[Pose] = []
        self._smooth: list[Pose] = []
        self._velocity = STANDSTILL
        self._frozen_at: float | None = None

    def pass_on(
        self,
        seen: list[Pose],
        now: float,
        velocity: Velocity,
        *,
        frozen: bool = False,
        extrapolates: bool = False,
        share: float = 1.0,
    ) -> list[Pose]:
        """Return the markers to send.

        Args:
            seen: Those in the image, in base_link.
            now: Seconds since the start.
            velocity: Of the robot.
            frozen: Whether the last image is repeated.
            extrapolates: Whether that goes on moving as it did.
            share: The weight of this image in the mean of all images; 1 is no smoothing.
        """
        if (frozen or extrapolates) and self._last:
            self._frozen_at = now if self._frozen_at is None else self._frozen_at
            seconds = now - self._frozen_at if extrapolates else 0.0
            moved = Pose(self._velocity.linear_x * seconds, 0.0, self._velocity.angular_z * seconds)
            return [one.relative_to(moved) for one in self._last]
        self._frozen_at = None
        if len(self._smooth) == len(seen) and share < 1.0:
            seen = [_towards(before, one, share) for before, one in zip(self._smooth, seen, strict=True)]
        self._smooth = seen or self._smooth
        self._last, self._velocity = seen or self._last, velocity
        return seen


def _towards(before: Pose, after: Pose, share: float) -> Pose:
    off = Pose(after.x - before.x, after.y - before.y, after.theta - before.theta)
    return Pose(before.x + share * off.x, before.y + share * off.y, before.theta + share * off.theta)
