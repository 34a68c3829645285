"""Thins a recording for the replay of its goal: laser scans, commanded velocities, the battery and the log."""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from dock_gateway.core.frames import frame_name, transform_of
from dock_gateway.core.graph import TRANSFORMS
from dock_gateway.core.laser import scan_points, spread
from dock_gateway.extensions.recordings.goal_log import DIAGNOSTICS, LOG, GoalLog
from dock_gateway.ros.raw_port import EchoType
from robot_io.recording import Sample, read
from robot_io.transform_tree import TransformTree

SCAN, ODOMETRY, BATTERY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "sensor_msgs/msg/BatteryState"
VELOCITIES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
# Nanoseconds between two messages of a topic that are used.
INTERVAL_NS = 200_000_000
# The maximum number of messages of each kind.
MOST = 400
# The maximum number of points of a scan.
MOST_POINTS = 180
# The maximum number of scans in memory while a recording is read. If there are more, those used are farther apart.
MOST_SCANS = 4_000
# The same for messages of each other kind.
MOST_HELD = 100_000
# Parts of the time whose extreme values are kept; two quantities need at most half of `MOST`.
PARTS = 50


class Replay:
    """Reads a recording; blocks.

    Args:
        began_ns: When the goal began, in ns since 1970.
        velocity: Name of the velocity topic, without its namespace.
        robot: The namespace of the robot.
    """

    def __init__(self, began_ns: int, velocity: str, robot: str) -> None:
        self._began_ns = began_ns
        self._velocity = velocity
        self._tree = TransformTree()
        self._base = "base_link"
        self._kinds: dict[str, EchoType] = {}
        self._topics: dict[str, str] = {}  # the first of each kind
        self._used_ns: dict[str, int] = {}
        self._interval_ns: dict[str, int] = {}
        self._log = GoalLog(robot)
        self._found: dict[str, list[dict[str, Any]]] = {"scans": [], "velocity": [], "battery": []}

    def read(self, path: Path, covered: Callable[[str], bool]) -> dict[str, Any]:
        """Return what the replay shows, of the topics that are covered. Times are seconds since the goal began.

        Raises:
            OSError: There is no such file.
        """
        for sample in read(path):
            if covered(sample.topic):
                with suppress(Exception):  # whatever the bytes of others bring about; a frame that is not known
                    self._take(sample)
        return {kind: thinned(found) for kind, found in self._found.items()} | {"log": self._log.lines()}

    def _take(self, sample: Sample) -> None:
        if sample.kind == TRANSFORMS:
            if sample.topic.endswith("_static"):
                self._relate(self._decoded(sample))
        elif sample.kind == ODOMETRY:
            if self._is_due(sample, "odometry"):
                self._used_ns["odometry"] = sample.received_ns
                self._base = frame_name(self._decoded(sample).child_frame_id) or self._base
        elif sample.kind in (LOG, DIAGNOSTICS):
            self._log.take(sample, self._decoded(sample), self._offset(sample))
        else:
            self._show(sample)

    def _show(self, sample: Sample) -> None:
        if sample.kind == SCAN:
            self._use(sample, "scans", self._scan)
        elif sample.kind == BATTERY:
            self._use(sample, "battery", _battery)
        elif sample.kind in VELOCITIES and sample.topic.endswith(f"/{self._velocity}"):
            self._use(sample, "velocity", _velocity)

    def _is_due(self, sample: Sample, what: str) -> bool:
        """Return whether a message is of the topic that is used, and not too soon after the last one that was used."""
        if self._topics.setdefault(what, sample.topic) != sample.topic:
            return False
        return sample.received_ns - self._used_ns.get(what, 0) >= self._interval_ns.get(what, INTERVAL_NS)

    def _use(self, sample: Sample, what: str, describe: Callable[[Any], dict[str, Any]]) -> None:
        if sample.received_ns < self._began_ns - INTERVAL_NS or not self._is_due(sample, what):
            return
        described = describe(self._decoded(sample))
        self._found[what].append({"offset_s": self._offset(sample), **described})
        if _shows(described):  # else the next one may
            self._used_ns[what] = sample.received_ns
        if len(self._found[what]) >= (most := MOST_SCANS if what == "scans" else MOST_HELD):
            self._found[what] = thinned(self._found[what])
            self._interval_ns[what] = self._interval_ns.get(what, INTERVAL_NS) * most // MOST

    def _offset(self, sample: Sample) -> float:
        """Return when a message came, in seconds since the goal began."""
        return round((sample.received_ns - self._began_ns) / 1e9, 3)

    def _decoded(self, sample: Sample) -> Any:
        kind = self._kinds.get(sample.kind) or self._kinds.setdefault(sample.kind, EchoType(sample.kind))
        return kind.decode(sample.data)

    def _relate(self, message: Any) -> None:
        for each in message.transforms:
            with suppress(ValueError):  # the others of the message count
                parent, child = frame_name(each.header.frame_id), frame_name(each.child_frame_id)
                self._tree.add(parent, child, 0.0, transform_of(each.transform), fixed=True)

    def _scan(self, message: Any) -> dict[str, Any]:
        lies = self._tree.lookup(self._base, frame_name(message.header.frame_id), 0.0)
        return {"points": scan_points(message, lies, MOST_POINTS)}


def _velocity(message: Any) -> dict[str, Any]:
    twist = getattr(message, "twist", message)
    return {"linear": twist.linear.x, "angular": twist.angular.z}


def _battery(message: Any) -> dict[str, Any]:
    return {"voltage": message.voltage, "percentage": message.percentage}


def _shows(described: dict[str, Any]) -> bool:
    """Return whether there is something to draw."""
    if "points" in described:
        return bool(described["points"])
    return any(math.isfinite(value) for name, value in described.items() if name != "offset_s")


def thinned(found: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return at most `MOST`, evenly distributed among those that show something, with the ends and extreme values."""
    if len(found) <= MOST:
        return list(found)
    shown = [each for each in found if _shows(each)] or found
    kept = _extremes(shown)
    kept.update(spread(len(shown), MOST - len(kept)).tolist())
    return [shown[index] for index in sorted(kept)]


def _extremes(found: Sequence[dict[str, Any]]) -> set[int]:
    """Return the indices of the least and the greatest value of each quantity, in each part of the time."""
    kept: set[int] = set()
    for name in found[0].keys() - {"offset_s", "points"}:
        values = np.array([each[name] for each in found], dtype=np.float64)
        for part in np.array_split(np.flatnonzero(np.isfinite(values)), PARTS):
            if len(part):
                kept.update((int(part[values[part].argmin()]), int(part[values[part].argmax()])))
    return kept
