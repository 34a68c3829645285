"""Receives all goals on one action, through any number of links; decodes only the needed fields, on ROS's threads."""

import logging
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from dock_gateway.core.goal import Json
from dock_gateway.core.graph import ACTION_PART, FEEDBACK, STATUS
from dock_gateway.ros.action_link import ActionLink
from dock_gateway.ros.admission import MAX_PUBLISHERS, MAX_UNKNOWN, WINDOW, Admission, KnownGoals
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.listener import Handler, Unread
from dock_gateway.ros.losses import Losses, OnLoss
from dock_gateway.ros.messages.codec import MessageCodec
from dock_gateway.ros.status import StatusReader, StatusReport, text_of

log = logging.getLogger(__name__)

# Bytes before the goal id, the first field of a feedback message, and bytes of the id.
HEADER, ID_SIZE = 4, 16

OnStatus = Callable[[list[StatusReport], int], None]
OnFeedback = Callable[[str, Json, int], None]


class GoalListener:
    """Hears the feedback and the status messages of one action.

    Args:
        bridge: The bridge to the loop.
        action_name: Absolute name of the action.
        feedback: Encodes its feedback.
        goals: The goals that are known.
        on_status: Called on the loop with the changes in a status message and its source timestamp in ns.
        on_feedback: Called on the loop with a goal id, the feedback as JSON and the source timestamp in ns.
        on_loss: Called on the loop with a goal id, why its feedback was not read, and the number of messages.
        uses: Returns whether feedback is taken from a link.

    Attributes:
        admission: Decides which unknown goals the gateway gets to know.
    """

    def __init__(
        self,
        bridge: Bridge,
        action_name: str,
        feedback: MessageCodec,
        goals: KnownGoals,
        *,
        on_status: OnStatus,
        on_feedback: OnFeedback,
        on_loss: OnLoss,
        uses: Callable[[ActionLink], bool],
    ) -> None:
        self.admission = Admission(goals, lambda publisher: bridge.to_ros(partial(self._name_excess, publisher)))
        self._bridge = bridge
        self._action_name = action_name
        self._codec = feedback
        self._on_status = on_status
        self._on_feedback = on_feedback
        self._uses = uses
        self._losses = losses = Losses(bridge, on_loss)
        self._inbox = bridge.inbox(lambda goal_id, *_: losses.count(goal_id, Unread.TOO_FAST))
        self._newest_stamp = 0
        self._excess: str | None = None

    @property
    def excess(self) -> str | None:
        """The node that reports too many unknown goals, without a full stop; None if there is none."""
        return self._excess if self.admission.exceeded else None

    def listen(self, link: ActionLink) -> None:
        """Listen through a link; call it on the ROS thread of its bridge."""

        def wants_feedback(head: bytes, info: dict[str, Any]) -> bool:
            return self._uses(link) and self.admission.of_feedback(info["publisher"], _id_of(head))

        readers: dict[bytes, StatusReader] = {}
        feedback = Handler(self._hear_feedback, self._refuse_feedback, wants_feedback)
        link.listen(feedback, Handler(partial(self._hear_status, readers)))

    def _refuse_feedback(self, message: bytes, why: Unread) -> None:
        self._losses.count(text_of(_id_of(message)), why)

    def _hear_feedback(self, message: Any, info: dict[str, Any]) -> None:
        stamp = info["source_timestamp"]
        if stamp == self._newest_stamp:  # received through two links
            return
        self._newest_stamp = stamp
        feedback = self._codec.encode(message.feedback)
        goal_id = text_of(message.goal_id.uuid.tobytes())
        self._inbox.offer(len(feedback), self._on_feedback, goal_id, feedback, stamp)

    def _hear_status(self, readers: dict[bytes, StatusReader], message: bytes, info: dict[str, Any]) -> None:
        publisher = info["publisher"]
        if publisher not in readers:
            if len(readers) >= MAX_PUBLISHERS:
                readers.clear()
            readers[publisher] = StatusReader(partial(self.admission.of_status, publisher))
        reader = readers[publisher]
        reports = reader.read(message)
        if reader.worth_telling(time.monotonic()):
            self._inbox.put(self._on_status, reports, info["source_timestamp"])

    def _name_excess(self, publisher: bytes) -> None:
        """Log who brings up too many unknown goals; on the ROS thread."""
        prefix = f"{self._action_name}{ACTION_PART}"
        topics = (read_topic(self._bridge.node, f"{prefix}{part}") for part in (STATUS, FEEDBACK))
        endpoints = (endpoint for topic in topics for endpoint in topic.publishers)
        name = next((endpoint.node for endpoint in endpoints if endpoint.gid == publisher), None)
        self._excess = (
            f"{name or 'a node'} names more than {MAX_UNKNOWN} unknown goals in {WINDOW:g} s on {self._action_name}; "
            "the gateway ignores the others"
        )
        log.warning("%s", self._excess)


def _id_of(message: bytes) -> bytes:
    """Return the goal id in a feedback message, or in its first bytes."""
    return message[HEADER : HEADER + ID_SIZE]
