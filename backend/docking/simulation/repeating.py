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
    """A detector that repeats its last image, or lets the marker go on as it moved last."""

    __slots__ = ("_frozen_at", "_last", "_velocity")

    def __init__(self) -> None:
        self._last: list[Pose] = []
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
    ) -> list[Pose]:
        """Return the markers to send.

        Args:
            seen: Those in the image, in base_link.
            now: Seconds since the start.
            velocity: Of the robot.
            frozen: Whether the last image is repeated.
            extrapolates: Whether that goes on moving as it did.
        """
        if (frozen or extrapolates) and self._last:
            self._frozen_at = now if self._frozen_at is None else self._frozen_at
            seconds = now - self._frozen_at if extrapolates else 0.0
            moved = Pose(self._velocity.linear_x * seconds, 0.0, self._velocity.angular_z * seconds)
            return [one.relative_to(moved) for one in self._last]
        self._frozen_at = None
        self._last, self._velocity = seen or self._last, velocity
        return seen
