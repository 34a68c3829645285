"""Measures the pose of a robot on its dock as seen from the marker."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean, median, stdev

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Observation
from docking.estimation.poses import MAD

SHORTEST, LONGEST = 3.0, 10.0
"""Seconds that a measurement takes: it ends in between, as soon as the result is GOOD."""
FEWEST = 10
"""Detections that there must be."""
GOOD, TOLERABLE = (0.002, math.radians(0.3)), (0.005, math.radians(1.0))
"""Standard error of the mean, in m and rad, that ends the measurement; and that is still accepted at its end."""
MOVED = (0.005, math.radians(1.0))
"""How much odometry may change, in m and rad, while the robot stands still: that of some bases drifts."""
SILENT = 2.0
"""The longest time without odometry, in s."""
OUTLIER = 4.0
"""Detections farther from the median than this, in standard deviations, are left out."""
NEAR = (0.015, math.radians(2.0))
"""In m and rad. Detections within this of the median are never left out: that of rounded poses may deviate by 0."""
AGREEING = 0.6
"""The part of the detections that must agree."""


class CalibrationError(Exception):
    """There is no result; the text says why, as a sentence."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """The result.

    Attributes:
        docked: base_link in the marker's frame.
        count: Detections that it is the mean of.
        seconds: How long it took.
        distance_noise: Standard deviation of one detection, for each coordinate, in m.
        angle_noise: The same of its angle, in rad.
    """

    docked: Pose
    count: int
    seconds: float
    distance_noise: float
    angle_noise: float


class DockCalibration:
    """A measurement, step by step, of a robot that stands on its dock."""

    def __init__(self, started_at: float) -> None:
        """Begin.

        Args:
            started_at: Now, in seconds of the observations' clock.
        """
        self._started_at = self._last_stamp = started_at
        self._start: Pose | None = None
        self._seen: list[Pose] = []  # base_link in the marker's frame

    def step(self, observation: Observation) -> Calibration | None:
        """Add an observation.

        Args:
            observation: Current sensor readings.

        Returns:
            The result; None while the measurement goes on.

        Raises:
            CalibrationError: There is none.
        """
        lapse = observation.now - self._started_at
        self._check_standstill(observation)
        odometry, marker = observation.odometry, observation.marker
        if odometry is not None and marker is not None and marker.stamp > self._last_stamp:
            self._last_stamp = marker.stamp
            self._seen.append(odometry.pose.relative_to(marker.pose))  # odometry of now: it may drift
        if lapse < SHORTEST or (len(self._seen) < FEWEST and lapse < LONGEST):
            return None
        return self._conclude(lapse)

    def _check_standstill(self, observation: Observation) -> None:
        """Raise CalibrationError unless odometry shows that the robot stands still."""
        odometry = observation.odometry
        if observation.now - (self._started_at if odometry is None else odometry.stamp) > SILENT:
            raise CalibrationError("there is no odometry, so nothing tells that the robot stands still")
        if odometry is None:
            return
        if self._start is None:
            self._start = odometry.pose
        moved = odometry.pose.relative_to(self._start)
        if math.hypot(moved.x, moved.y) > MOVED[0] or abs(moved.theta) > MOVED[1]:
            raise CalibrationError("the robot moved: it must stand still on its dock")

    def _conclude(self, lapse: float) -> Calibration | None:
        if len(self._seen) < FEWEST:
            seen = f"only {len(self._seen)} times" if self._seen else "not"
            raise CalibrationError(
                f"the marker was {seen} detected within {lapse:.0f} s; {FEWEST} detections are needed"
            )
        agreeing = _without_outliers(self._seen)
        left_out = len(self._seen) - len(agreeing)
        agreed = len(agreeing) >= AGREEING * len(self._seen)
        if not agreed:
            agreeing = self._seen  # to say how much they spread; hardly any may be left
        count, first = len(agreeing), agreeing[0].theta
        xs, ys = [one.x for one in agreeing], [one.y for one in agreeing]
        turns = [normalize_angle(one.theta - first) for one in agreeing]
        distance_noise, angle_noise = max(stdev(xs), stdev(ys)), stdev(turns)
        errors = (distance_noise / math.sqrt(count), angle_noise / math.sqrt(count))
        if lapse < LONGEST and not (agreed and errors[0] <= GOOD[0] and errors[1] <= GOOD[1]):
            return None
        if not agreed or errors[0] > TOLERABLE[0] or errors[1] > TOLERABLE[1]:
            raise CalibrationError(
                f"the detections spread too much: by {1000.0 * distance_noise:.0f} mm and"
                f" {math.degrees(angle_noise):.1f}° (standard deviation), and {left_out} of"
                f" {len(self._seen)} were left out"
            )
        docked = Pose(fmean(xs), fmean(ys), normalize_angle(first + fmean(turns)))
        return Calibration(docked, count, lapse, distance_noise, angle_noise)


def _without_outliers(poses: Sequence[Pose]) -> list[Pose]:
    first = poses[0].theta
    columns = [[pose.x for pose in poses], [pose.y for pose in poses], [_turn(pose, first) for pose in poses]]
    middles = [median(column) for column in columns]
    limits = [
        max(OUTLIER * MAD * median(abs(value - middle) for value in column), near)
        for column, middle, near in zip(columns, middles, (NEAR[0], *NEAR), strict=True)
    ]
    return [
        pose
        for pose, *values in zip(poses, *columns, strict=True)
        if all(abs(value - middle) <= limit for value, middle, limit in zip(values, middles, limits, strict=True))
    ]


def _turn(pose: Pose, first: float) -> float:
    return normalize_angle(pose.theta - first)
