"""Odometry of the last seconds: where the robot was when something was seen."""

import math
from bisect import bisect_right
from collections import deque

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Odometry

KEPT = 2.0
"""Seconds of odometry to look back into."""
AHEAD = 0.25
"""Seconds beyond the newest odometry that the robot is taken to have gone on as it did."""


class Track:
    """Odometry by the moments at which it was measured, in seconds of the clock that the robot's messages carry.

    That clock may be a simulated one. What comes out carries the monotonic clock, as everything else here does.
    """

    def __init__(self) -> None:
        self._samples: deque[tuple[float, Odometry]] = deque()

    def __len__(self) -> int:
        """Return the number of measurements that are kept."""
        return len(self._samples)

    @property
    def latest(self) -> Odometry | None:
        """The newest; None before the first."""
        return self._samples[-1][1] if self._samples else None

    @property
    def latest_at(self) -> float:
        """The moment of the newest; NaN before the first."""
        return self._samples[-1][0] if self._samples else math.nan

    def add(self, measured_at: float, odometry: Odometry) -> None:
        """Add a newer measurement. An older one means that time was reset: the history is cleared.

        One of the same moment replaces the other: where no stamp is ever set, or a clock stands still, one is kept. But
        the same message again is none where stamps went on before: it says nothing of now.
        """
        latest = self.latest
        same = latest is not None and (odometry.pose, odometry.velocity) == (latest.pose, latest.velocity)
        if same and len(self) > 1 and measured_at == self._samples[-1][0]:
            return
        if self._samples and measured_at < self._samples[-1][0]:
            self._samples.clear()
        elif self._samples and measured_at == self._samples[-1][0]:
            self._samples.pop()
        self._samples.append((measured_at, odometry))
        while measured_at - self._samples[0][0] > KEPT:
            self._samples.popleft()

    def clear(self) -> None:
        """Forget everything."""
        self._samples.clear()

    def at(self, measured_at: float) -> Odometry:
        """The odometry at a moment, interpolated.

        Args:
            measured_at: The moment; 0, a stamp that was not set, is now.

        Raises:
            LookupError: There is none for that moment; the caller adds the subject to the message.
        """
        if not self._samples:
            raise LookupError("before any odometry")
        first, last = self._samples[0][0], self._samples[-1][0]
        if measured_at == 0.0:
            return self._samples[-1][1]
        if measured_at < first - AHEAD:
            raise LookupError(f"{last - measured_at:.1f} s before the latest odometry")
        if measured_at > last + AHEAD:
            raise LookupError(f"{measured_at - last:.1f} s after the latest odometry")
        index = bisect_right(self._samples, measured_at, key=lambda sample: sample[0])
        if index == 0:
            return self._samples[0][1]
        before_at, before = self._samples[index - 1]
        if index == len(self._samples):
            return _go_on(before, measured_at - before_at)
        after_at, after = self._samples[index]
        return _between(before, after, (measured_at - before_at) / (after_at - before_at))

    def arrival(self, measured_at: float, received: float) -> float:
        """Return when odometry of a moment arrived, or will arrive, by the monotonic clock.

        What was measured at that moment belongs to that odometry, however late either of them is.

        Args:
            measured_at: The moment; 0 is a stamp that was not set.
            received: When what was measured then arrived. It is the answer, too, where the stamp was not set, or is so
                far off that the clocks of the two publishers do not agree.
        """
        if measured_at == 0.0:
            return received
        try:
            arrival = self.at(measured_at).stamp
        except LookupError:
            return received
        return arrival if abs(arrival - received) <= AHEAD else received


def _go_on(odometry: Odometry, seconds: float) -> Odometry:
    velocity = odometry.velocity
    moved = odometry.pose.compose(
        Pose(velocity.linear_x * seconds, velocity.linear_y * seconds, velocity.angular_z * seconds)
    )
    return Odometry(moved, velocity, odometry.stamp + seconds)


def _between(before: Odometry, after: Odometry, share: float) -> Odometry:
    turned = normalize_angle(after.pose.theta - before.pose.theta)
    pose = Pose(
        before.pose.x + share * (after.pose.x - before.pose.x),
        before.pose.y + share * (after.pose.y - before.pose.y),
        normalize_angle(before.pose.theta + share * turned),
    )
    return Odometry(pose, after.velocity, before.stamp + share * (after.stamp - before.stamp))
