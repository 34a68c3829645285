"""Finds out whether the marker is seen to move as the robot drives, and how old its detections are."""

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
FITS = 2.5
"""The most that detections of one place cost, in the mean: 1.5 is usual, and more where the robot was pushed."""
FORGETTING = 0.99
"""The weight of a detection in the next one, for the lag."""
PRIOR = 10.0
"""What each second of lag must explain, as a logarithm of a likelihood."""
AGAINST: npt.NDArray[np.float64] = np.asarray(PRIOR * np.abs(LAGS), dtype=np.float64)
"""What speaks against each lag before anything was seen."""
KEPT, SPACING = 20.0, 0.1
"""Seconds of odometry that are kept, and between two of its poses at least."""
PERIOD = 0.12
"""Seconds between two comparisons, at least: what moves shows no sooner, and each takes about 1 ms."""
RECOVERED = 3
"""Detections, after those that were not believed, whose median shows whether it is another image."""
DIFFERENT = 4.0
"""Standard deviations by which that differs, and at least:"""
SECOND_CHANCE = 5.0
"""Seconds after the first doubt, after which the robot creeps on: it may have been pushed, and sees what is right."""
REPEATED = np.array((0.002, 0.002, 0.01))
"""In m, m and rad; detections that differ by less, as seen from the robot, may be of one image."""
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
    with the robot: the detector repeats an image, or the robot does not move although odometry says so. Such detections
    are not believed before there are others. Where it scatters less with the odometry of an earlier moment, detections
    are older than their stamps.

    Attributes:
        lag: How much older detections are than their stamps, in s.
        latest: The longest lag that is not ruled out yet, in s.
        proven: Whether the marker has moved as the robot drove, since the last `begin`.
        doubt: Why detections are not believed now, as a sentence; empty while they are.
        doubts: How often they were not.
    """

    def __init__(self) -> None:
        """Begin without a detection."""
        self.doubt = ""
        self.doubts = 0
        self._odometry: deque[tuple[float, float, float, float]] = deque()  # stamp, x, y, heading without jumps
        self._seen: deque[tuple[float, float, float, float]] = deque(maxlen=WINDOWS[-1])  # stamp, pose in base_link
        self._doubted: tuple[Array, Array] | None = None  # that pose, and by how much another image differs
        self._compared_at = self._doubted_at = -math.inf
        self.begin()

    def begin(self) -> None:
        """Compare the next detections alone: those before were not believed, or the wheels may have slipped."""
        self.proven = False
        self._seen.clear()
        self._evidence, self._candidate = AGAINST.copy(), NOT_LATE  # of each lag: less is better
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
        if len(track) > 1 and stamp - track[-2][0] < SPACING:
            track.pop()
        track.append((stamp, robot.x, robot.y, heading))
        while stamp - track[0][0] > KEPT:
            track.popleft()
            while self._seen and self._seen[0][0] - LAGS[-1] < track[0][0]:
                self._seen.popleft()  # nothing tells any more where the robot was then

    def place(self, marker: Pose, stamp: float) -> Pose:
        """Return the marker in odom where it was when the image was made.

        Args:
            marker: In odom, by the odometry of its stamp.
            stamp: In s.
        """
        if self.lag == 0.0 or not self._odometry:
            return marker
        return self._at(stamp - self.lag).compose(marker.relative_to(self._at(stamp)))

    def believes(self, marker: Pose, stamp: float) -> bool:
        """Take in a detection, and say whether it is believed; `doubt` says why not.

        Args:
            marker: In odom, by the odometry of its stamp.
            stamp: In s.
        """
        if not self._odometry:
            return True
        seen = marker.relative_to(self._at(stamp))
        theta = seen.theta if not self._seen else self._seen[-1][3] + normalize_angle(seen.theta - self._seen[-1][3])
        self._seen.append((stamp, seen.x, seen.y, theta))
        if self._doubted is not None:
            return self._is_another(*self._doubted)
        if len(self._seen) < WINDOWS[0] or abs(stamp - self._compared_at) < PERIOD:
            return True
        self._compared_at = stamp
        return self._compare()

    def _is_another(self, doubted: Array, different: Array) -> bool:
        """Whether the last detections are of another image than those that were not believed."""
        if len(self._seen) < RECOVERED:
            return False
        off = np.median(np.array(self._seen)[-RECOVERED:, 1:], axis=0) - doubted
        off[2] = normalize_angle(off[2])
        second_chance = self.doubts == 1 and self._seen[-1][0] - self._doubted_at > SECOND_CHANCE
        if (np.abs(off) < different).all() and not second_chance:
            return False
        self.doubt, self._doubted = "", None
        self.begin()
        return True

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

    def _compare(self) -> bool:
        """Whether the marker moves as the robot does, or nothing tells."""
        seen = np.array(self._seen)
        since = seen[0, 0] - LAGS[-1] - SPACING
        odometry = np.array([*(one for one in self._odometry if one[0] >= since), self._soon()])
        if (odometry[:, 1:].max(axis=0) - odometry[:, 1:].min(axis=0)).sum() < UNTURNED:
            return True
        moments = seen[:, 0] - LAGS[:, None]
        ways = np.stack([np.interp(moments, odometry[:, 0], odometry[:, i]) for i in (1, 2, 3)])
        placed = _placed(seen[:, 1:].T[:, None, :], ways)
        distance, way = np.hypot(seen[:, 1], seen[:, 2]), ways[:, NOT_LATE]
        last = slice(-LAG_WINDOW, None)
        self._learn_lag(_costs(placed[..., last], distance[last], way[:, last])[:-1])
        chosen = placed[:, [*self._allowed, -1]]
        for count in WINDOWS:
            last = slice(-count, None)
            if count > len(seen) or np.ptp(way[2, last]) > math.pi:  # after a full turn, all looks as before
                break
            *stands, follows = _costs(chosen[..., last], distance[last], way[:, last])
            if min(stands) - follows > SURE and follows < FITS * count:
                self._disbelieve(seen[last], ways[:, self._candidate, last])
                return False
            self.proven |= bool(follows - min(stands) > SURE)
        return True

    @property
    def _allowed(self) -> list[int]:
        """The lags that are not ruled out."""
        return np.flatnonzero(self._evidence - self._evidence.min() < SURE).tolist()

    def _learn_lag(self, costs: Array) -> None:
        share = 1.0 / min(LAG_WINDOW, len(self._seen))
        before = FORGETTING * (self._evidence - AGAINST)
        self._evidence = AGAINST + before + share * (costs - costs.min())
        best = int(self._evidence.argmin())
        if self._evidence[self._candidate] - self._evidence[best] > SURE / 2.0:
            self._candidate = best
            self.lag = max(0.0, float(LAGS[best]))
        self.latest = max(self.lag, float(LAGS[self._allowed[-1]]))

    def _disbelieve(self, seen: Array, way: Array) -> None:
        driven = float(np.hypot(np.ptp(way[0]), np.ptp(way[1])))
        seconds = seen[-1, 0] - seen[0, 0]
        self.doubt = (
            f"the marker was seen at one place while odometry measured {driven:.2f} m and"
            f" {math.degrees(np.ptp(way[2])):.0f} degrees within {seconds:.1f} s: its detector repeats an image, or the"
            " robot does not move and its odometry reports commands"
        )
        self.doubts += 1
        self._doubted_at = seen[-1, 0]
        last = seen[-WINDOWS[0] :, 1:]
        self._doubted = np.median(last, axis=0), np.maximum(REPEATED, DIFFERENT * last.std(axis=0))
        self.begin()


def _costs(placed: Array, distance: Array, way: Array) -> Array:
    """Return how improbable each hypothesis about the marker is, as minus the logarithm of a likelihood.

    Args:
        placed: The detections where they would be equal but for noise; shape (3, hypotheses, n).
        distance: From the robot to the marker, in m; shape (n,).
        way: x, y and heading by odometry at the moments of the detections; shape (3, n).
    """
    x, y, turned = (way.max(axis=1) - way.min(axis=1)).tolist()
    position = (POSITION * (1.0 + DISTANCE * distance)) ** 2 + (MISJUDGED * (math.hypot(x, y) + turned * distance)) ** 2
    angle = ANGLE**2 + (MISJUDGED * turned) ** 2
    off = placed - _middle(placed)[:, :, None]
    off *= off
    squared = (off[0] + off[1]) / position + off[2] / angle
    factor = min(FACTORS[1], max(FACTORS[0], float(_middle(squared).min()) / MEDIAN_3))
    return np.asarray(0.5 * np.minimum(squared / factor, CLIP).sum(axis=1))


def _middle(values: Array) -> Array:
    """The median along the last axis; the upper one of an even number."""
    half = values.shape[-1] // 2
    return np.asarray(np.partition(values, half, axis=-1)[..., half])


def _placed(seen: Array, ways: Array) -> Array:
    """The marker in odom, by the odometry of each lag, and at last as seen from the robot; shape (3, lags + 1, n)."""
    cos, sin = np.cos(ways[2]), np.sin(ways[2])
    x, y, theta = seen
    in_odom = np.stack((ways[0] + cos * x - sin * y, ways[1] + sin * x + cos * y, ways[2] + theta))
    return np.concatenate((in_odom, seen), axis=1)
