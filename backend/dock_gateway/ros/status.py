"""Reads messages of `_action/status` as bytes and reports the changes.

An action server publishes every goal that it remembers whenever one of them changes. rclpy takes 60 ms to decode a
message of 3,000 goals, without a break; reading the bytes takes 2 ms. Only the reports leave the listener's thread.
"""

import heapq
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from dock_gateway.core.goal import FROM_ROS, GoalStatus

# Seconds between two messages without news that are passed on.
LIFE_INTERVAL = 0.2
# The rank of a goal that has not changed; lower ones come first.
KNOWN = 2

# First bytes of a message → byte order; CDR and XCDR2.
_ENCODINGS = {b"\0\0": ">", b"\0\1": "<", b"\0\6": ">", b"\0\7": "<"}
# Bytes before the body. Four-byte numbers are aligned to multiples of four from there, so the first goal has no padding
# but the others do. A goal is its id, the time when it was accepted (seconds, nanoseconds) and the status.
_BODY = 4


@dataclass(frozen=True)
class StatusReport:
    """One goal in a message of `_action/status`. `accepted_ns`: when the server accepted it."""

    goal_id: str
    status: GoalStatus
    accepted_ns: int


class StatusReader:
    """Reads the status messages of one publisher and reports the changes.

    Running goals are reported with every message, as a sign of life; ended goals only once. If there are more than
    `max_reports`, running goals that changed come first, then ended ones, then unchanged ones; the newest of each.

    Args:
        admits: Returns whether to report a goal, by the bytes of its id. If not, it is new in the next message again.
        max_reports: The maximum number of goals reported per message. The rest is reported with the next message.
    """

    def __init__(self, admits: Callable[[bytes], bool] = lambda _: True, *, max_reports: int = 1000) -> None:
        self._admits = admits
        self._max_reports = max_reports
        self._reports: dict[bytes, StatusReport] = {}
        self._is_news = False
        self._told_at = float("-inf")

    def read(self, message: bytes) -> list[StatusReport]:
        """Return the goals to report from a message, in its order.

        Raises:
            ValueError: It is not a status message.
        """
        before, self._reports = self._reports, {}
        news: list[tuple[int, int, int, bytes, GoalStatus]] = []
        for index, (goal_id, accepted_ns, status) in enumerate(_goals(message)):
            report = before.get(goal_id)
            known = report is not None and (report.status, report.accepted_ns) == (status, accepted_ns)
            if report is not None and known:
                self._reports[goal_id] = report
            if not (known and status.terminal):
                rank = KNOWN if known else 1 if status.terminal else 0
                news.append((rank, -accepted_ns, index, goal_id, status))
        reported = heapq.nsmallest(self._max_reports, news) if len(news) > self._max_reports else sorted(news)
        reports: dict[int, StatusReport] = {}
        self._is_news = False
        for rank, age, index, goal_id, status in reported:
            if rank == KNOWN:
                reports[index] = self._reports[goal_id]
            elif self._admits(goal_id):
                reports[index] = self._reports[goal_id] = StatusReport(text_of(goal_id), status, -age)
                self._is_news = True
        return [reports[index] for index in sorted(reports)]

    def worth_telling(self, now: float) -> bool:
        """Return whether the last message brought news, or is the first for a while and so a sign of life.

        Args:
            now: Seconds on the monotonic clock.
        """
        if not self._is_news and now - self._told_at < LIFE_INTERVAL:
            return False
        self._told_at = now
        return True


def _goals(message: bytes) -> Iterator[tuple[bytes, int, GoalStatus]]:
    """Yield id, time of acceptance in ns and status of each goal."""
    order = _ENCODINGS.get(message[:2])
    if order is None:
        raise ValueError(f"a message is encoded in an unknown way: {message[:2].hex()}")
    try:
        (count,) = struct.unpack_from(f"{order}I", message, _BODY)
        first, rest = struct.Struct(f"{order}16siIb"), struct.Struct(f"{order}16s3xiIb")
        begin = _BODY + 4 + first.size
        entries = [first.unpack_from(message, _BODY + 4)] if count else []
        entries += rest.iter_unpack(message[begin : begin + rest.size * (count - 1)] if count else b"")
    except struct.error as error:
        raise ValueError(f"not a status message: {error}") from None
    if len(entries) != count:
        raise ValueError(f"a status message with {len(entries)} goals has a count of {count}")
    for goal_id, seconds, nanoseconds, number in entries:
        if (status := FROM_ROS.get(number)) is not None:
            yield goal_id, seconds * 1_000_000_000 + nanoseconds, status


def text_of(goal_id: bytes) -> str:
    """Convert the bytes of a goal id to its text form, as in JSON."""
    text = goal_id.hex()
    return f"{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:]}"
