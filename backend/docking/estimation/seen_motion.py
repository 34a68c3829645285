"""Whether the marker is seen to move as the robot drives, and how old its detections are."""

import math
from collections import deque
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose, normalize_angle

LAGS: npt.NDArray[np.float64] = np.arange(-3.0, 10.0) * 0.1
"""Candidates, in s, for how much older a detection is than its stamp; below 0 odometry is older than its own."""
NOT_LATE = 3
"""The index of no lag."""
WINDOWS = (6, 12, 24, 48)
"""Numbers of detections over which the candidates are compared: the fewest see it first, the most see it in noise."""
LAG_WINDOW = 24
"""Detections over which the scatter is compared that tells the lag."""
SURE = 15.0
"""Logarithm of the likelihood ratio from which one candidate is taken instead of another."""
FORGETTING = 0.99
"""The weight of a detection in the next one, for the lag."""
PRIOR = 10.0
"""What each second of lag must explain, as a logarithm of a likelihood."""
AGAINST: npt.NDArray[np.float64] = np.asarray(PRIOR * np.abs(LAGS), dtype=np.float64)
"""What speaks against each lag before anything was seen."""
KEPT = 10.0
"""Seconds of odometry that are kept."""
SOON = 0.35
"""Seconds for which the robot is taken to drive on as it does, where odometry of that moment has not come yet."""
POSITION, DISTANCE, ANGLE = 0.01, 0.5, math.radians(1.5)
"""Usual noise: in m, at 0 m; how much more it is for each m, as a fraction; in rad."""
FACTORS = (0.25, 64.0)
"""Bounds of the measured variance, as multiples of the usual one."""
MEDIAN_3 = 2.37
"""Median of the sum of three squared standard normal variables."""
CLIP = 25.0
"""The most that one detection counts, in squared standard deviations: it may be an outlier."""
MISJUDGED = 0.07
"""The part of a motion that odometry may misjudge: slip, wheels that are not alike."""
UNTURNED = 0.02
"""In m; less motion says nothing."""

Array = npt.NDArray[np.float64]


class SeenMotion:
    """Compares the motion of the marker, as seen from the robot, with the motion by odometry.

    A marker that stands still is always at one place in odom. Where it scatters less as seen from the robot, it moves
    with the robot: the detector repeats an image, or the robot does not move although odometry says so. Where it
    scatters less with the odometry of an earlier moment, detections are older than their stamps.

    Attributes:
        lag: How much older detections are than their stamps, in s.
        latest: The longest lag that is not ruled out yet, in s.
        proven: Whether the marker has moved as the robot drove, since the last `begin`.
    """

    def __init__(self) -> None:
        """Begin without a detection."""
        self.lag = 0.0
        self.latest = float(LAGS[-1])
        self.proven = False
        self._odometry: deque[tuple[float, float, float, float]] = deque()  # stamp, x, y, heading without jumps
        self._seen: deque[tuple[float, float, float, float]] = deque(maxlen=WINDOWS[-1])
        self._evidence: Array = AGAINST.copy()  # of each lag: less is better
        self._candidate = NOT_LATE

    def begin(self) -> None:
        """Compare the next detections alone: those before were not believed, or of another marker."""
        self.proven = False
        self._seen.clear()
        self._evidence, self._candidate = AGAINST.copy(), NOT_LATE
        self.lag, self.latest = 0.0, float(LAGS[-1])

    def drive(self, stamp: float, robot: Pose) -> None:
        """Note odometry.

        Args:
            stamp: Of it, in s.
            robot: base_link in odom.
        """
        track = self._odometry
        if track and stamp <= track[-1][0]:
            return
        heading = robot.theta if not track else track[-1][3] + normalize_angle(robot.theta - track[-1][3])
        track.append((stamp, robot.x, robot.y, heading))
        while stamp - track[0][0] > KEPT:
            track.popleft()

    def place(self, marker: Pose, stamp: float) -> Pose:
        """Return the marker in odom where it was when the image was made.

        Args:
            marker: In odom, by the odometry of its stamp.
            stamp: In s.
        """
        if self.lag == 0.0 or not self._odometry:
            return marker
        return self._at(stamp - self.lag).compose(marker.relative_to(self._at(stamp)))

    def see(self, marker: Pose, stamp: float) -> str:
        """Take in a detection.

        Args:
            marker: In odom, by the odometry of its stamp.
            stamp: In s.

        Returns:
            What speaks against it as a sentence; empty while nothing does.
        """
        if not self._odometry:
            return ""
        seen = marker.relative_to(self._at(stamp))
        theta = seen.theta if not self._seen else self._seen[-1][3] + normalize_angle(seen.theta - self._seen[-1][3])
        self._seen.append((stamp, seen.x, seen.y, theta))
        if len(self._seen) < WINDOWS[0]:
            return ""
        return self._compare()

    def last(self) -> Pose:
        """The last detection, in base_link."""
        _, x, y, theta = self._seen[-1]
        return Pose(x, y, theta)

    def _at(self, stamp: float) -> Pose:
        """Odometry at a moment, interpolated."""
        track = self._odometry
        later = track[-1]
        if stamp >= later[0] or len(track) == 1:
            return Pose(later[1], later[2], normalize_angle(later[3]))
        for after, before in pairwise(reversed(track)):
            if before[0] <= stamp:
                share = (stamp - before[0]) / (after[0] - before[0])
                x, y, theta = (b + share * (a - b) for a, b in zip(after[1:], before[1:], strict=True))
                return Pose(x, y, normalize_angle(theta))
        return Pose(track[0][1], track[0][2], normalize_angle(track[0][3]))

    def _soon(self) -> tuple[float, float, float, float]:
        """Odometry as it will be in a moment, if the robot drives on as it does."""
        track = self._odometry
        last = track[-1]
        before = next((one for one in reversed(track) if last[0] - one[0] >= 0.1), track[0])
        if last[0] <= before[0]:
            return last[0] + SOON, *last[1:]
        share = SOON / (last[0] - before[0])
        x, y, theta = (a + share * (a - b) for a, b in zip(last[1:], before[1:], strict=True))
        return last[0] + SOON, x, y, theta

    def _compare(self) -> str:
        seen, odometry = np.array(self._seen), np.array((*self._odometry, self._soon()))
        ways = np.stack([np.interp(seen[:, 0] - LAGS[:, None], odometry[:, 0], odometry[:, i]) for i in (1, 2, 3)])
        if np.ptp(ways, axis=(1, 2)).sum() < UNTURNED:
            return ""
        self._learn_lag(_costs(seen[-LAG_WINDOW:], ways[:, :, -LAG_WINDOW:])[0])
        allowed = self._allowed
        for count in WINDOWS:
            if count > len(seen):
                break
            stands, follows = _costs(seen[-count:], ways[:, allowed, -count:])
            if stands.min() - follows > SURE:
                return self._describe(seen[-count:], ways[:, self._candidate, -count:])
            self.proven |= bool(follows - stands.min() > SURE)
        return ""

    @property
    def _allowed(self) -> list[int]:
        """The lags that are not ruled out."""
        return [number for number, one in enumerate(self._evidence) if one - self._evidence.min() < SURE]

    def _learn_lag(self, costs: Array) -> None:
        share = 1.0 / min(LAG_WINDOW, len(self._seen))
        before = FORGETTING * (self._evidence - AGAINST)
        self._evidence = AGAINST + before + share * (costs - costs.min())
        best = int(self._evidence.argmin())
        if self._evidence[self._candidate] - self._evidence[best] > SURE / 2.0:
            self._candidate = best
            self.lag = max(0.0, float(LAGS[best]))
        self.latest = max(self.lag, float(LAGS[self._allowed[-1]]))

    def _describe(self, seen: Array, way: Array) -> str:
        driven = float(np.hypot(np.ptp(way[0]), np.ptp(way[1])))
        seconds = seen[-1, 0] - seen[0, 0]
        return (
            f"the marker was seen at one place while odometry measured {driven:.2f} m and"
            f" {math.degrees(np.ptp(way[2])):.0f} degrees within {seconds:.1f} s: its detector repeats an image, or the"
            " robot does not move and its odometry reports commands"
        )


def _costs(seen: Array, ways: Array) -> tuple[Array, float]:
    """How improbable it is that the marker stands, for each lag, and that it moves with the robot.

    Args:
        seen: Detections; shape (n, 4): stamp, and pose in base_link.
        ways: x, y and heading by odometry at their moments; shape (3, lags, n).

    Returns:
        Minus the logarithms of likelihoods.
    """
    distance = np.hypot(seen[:, 1], seen[:, 2])
    way, turned = np.hypot(np.ptp(ways[0, 0]), np.ptp(ways[1, 0])), np.ptp(ways[2, 0])
    position = (POSITION * (1.0 + DISTANCE * distance)) ** 2 + (MISJUDGED * (way + turned * distance)) ** 2
    angle = ANGLE**2 + (MISJUDGED * turned) ** 2
    with_robot = seen[:, 1:].T[:, None, :]
    placed = np.concatenate((_placed(with_robot, ways), with_robot), axis=1)
    off = placed - _middle(placed)[:, :, None]
    squared = (off[0] ** 2 + off[1] ** 2) / position + off[2] ** 2 / angle
    factor = np.clip(_middle(squared).min() / MEDIAN_3, *FACTORS)
    costs = 0.5 * np.minimum(squared / factor, CLIP).sum(axis=1)
    return costs[:-1], float(costs[-1])


def _middle(values: Array) -> Array:
    """The median along the last axis; the upper one of an even number."""
    half = values.shape[-1] // 2
    return np.asarray(np.partition(values, half, axis=-1)[..., half])


def _placed(seen: Array, ways: Array) -> Array:
    """The marker in odom, by the odometry of each lag; shape (3, lags, n)."""
    cos, sin = np.cos(ways[2]), np.sin(ways[2])
    x, y, theta = seen
    return np.stack((ways[0] + cos * x - sin * y, ways[1] + sin * x + cos * y, ways[2] + theta))
