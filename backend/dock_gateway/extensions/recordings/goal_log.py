"""The lines that nodes of a robot logged while a goal ran, and what its diagnostics warned of."""

from collections import deque
from typing import Any

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

    def take(self, offset_s: float, message: Any, topic: str) -> None:
        """Take a line, or diagnoses, of which those count that are worse or better than before.

        Args:
            offset_s: When it came, in seconds since the goal began.
            message: An `rcl_interfaces/Log` or a `diagnostic_msgs/DiagnosticArray`.
            topic: Where it was published; on `/diagnostics` all robots do.
        """
        if not hasattr(message, "status"):
            level = LINE_LEVELS.get(message.level)
            if offset_s >= 0 and level is not None and self._is_ours(message.name, "."):
                self._add(offset_s, level, message.name, message.msg)
            return
        for status in message.status:
            if topic.count("/") > 1 or self._is_ours(status.name.strip("/"), "/"):
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
        room = MOST_LINES - len(self._troubles)
        shown = [*self._troubles, *list(self._lines)[len(self._lines) - min(room, len(self._lines)) :]]
        return sorted(shown, key=lambda line: line["offset_s"])
