"""The lines that nodes of a robot logged while a goal ran, and what its diagnostics warned of."""

from collections import deque
from itertools import islice
from typing import Any

from robot_io.recording import Sample

LOG, DIAGNOSTICS = "rcl_interfaces/msg/Log", "diagnostic_msgs/msg/DiagnosticArray"
# The levels of a line and of a diagnosis, in words. Lines for debugging are left out.
LINE_LEVELS = {20: "info", 30: "warning", 40: "error", 50: "fatal"}
DIAGNOSIS_LEVELS = {0: "info", 1: "warning", 2: "error", 3: "error"}
# The maximum number of lines. If there are more, the first are left out, and those that warn of nothing before others.
MOST_LINES = 400
# The maximum length of a text, and of the name of a node, in characters.
MOST_TEXT, MOST_NODE = 1000, 255
# The maximum number of diagnoses that are followed.
MOST_DIAGNOSES = 1000


class GoalLog:
    """Collects the lines.

    Args:
        robot: The namespace of the robot. Lines of nodes in the namespaces of others are left out.
    """

    def __init__(self, robot: str) -> None:
        self._parts = [part for part in robot.split("/") if part]
        self._lines: deque[dict[str, Any]] = deque(maxlen=MOST_LINES)
        self._troubles: deque[dict[str, Any]] = deque(maxlen=MOST_LINES)
        self._levels: dict[str, int] = {}

    def take(self, sample: Sample, message: Any, offset_s: float) -> None:
        """Take a line, or diagnoses, of which those count that are worse or better than before.

        Args:
            sample: The recorded message, of the type `LOG` or `DIAGNOSTICS`.
            message: The same, decoded.
            offset_s: When it came, in seconds since the goal began.
        """
        if sample.kind == LOG:
            level = LINE_LEVELS.get(message.level)
            if offset_s >= 0 and level is not None and self._is_ours(message.name, "."):
                self._add(offset_s, level, message.name, message.msg)
            return
        shared = sample.topic.count("/") == 1  # `/diagnostics`, where all robots publish
        for status in message.status:
            if not shared or self._is_ours(status.name.strip("/"), "/"):
                self._take_diagnosis(offset_s, status)

    def _take_diagnosis(self, offset_s: float, status: Any) -> None:
        level, before = ord(status.level), self._levels.get(status.name, 0)
        if level == before or (status.name not in self._levels and len(self._levels) >= MOST_DIAGNOSES):
            return
        self._levels[status.name] = level
        if offset_s >= 0:
            self._add(offset_s, DIAGNOSIS_LEVELS.get(level, "info"), status.name, status.message or "OK")

    def _is_ours(self, name: str, separator: str) -> bool:
        return name.split(separator)[: len(self._parts)] == self._parts

    def _add(self, offset_s: float, level: str, node: str, text: str) -> None:
        line = {"offset_s": offset_s, "level": level, "node": node[:MOST_NODE], "text": text[:MOST_TEXT]}
        (self._lines if level == "info" else self._troubles).append(line)

    def lines(self) -> list[dict[str, Any]]:
        """Return the lines, the first first."""
        surplus = max(0, len(self._troubles) + len(self._lines) - MOST_LINES)
        return sorted([*self._troubles, *islice(self._lines, surplus, None)], key=lambda line: line["offset_s"])
