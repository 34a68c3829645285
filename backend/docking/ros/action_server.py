"""An action server that knows which goal it is asked about."""

import uuid
from typing import Any

from rclpy.action import ActionServer

RESULT_TIMEOUT = 10
"""How long the result of a goal that has ended can be fetched, in whole seconds."""


class IdentifyingActionServer(ActionServer):  # type: ignore[misc] # rclpy has no types
    """An rclpy ActionServer whose goal callback can ask for the id of the goal it decides on.

    rclpy hands the goal callback the goal's fields and no id, so that a rejection could not be attributed. Of all
    ways around that, `execute` of the Waitable interface is the one least bound to rclpy's inside: it is given the
    whole request, and calls the goal callback before anything else can run.

    Attributes:
        deciding_on: Inside the goal callback: the id of the goal.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self.deciding_on = ""
        super().__init__(*args, result_timeout=RESULT_TIMEOUT, **kwargs)

    async def execute(self, taken_data: dict[str, Any]) -> None:
        """Note the goal id of a request, then go on as always."""
        if "goal" in taken_data:
            _header, request = taken_data["goal"]
            self.deciding_on = goal_id_text(request.goal_id)
        await super().execute(taken_data)


def goal_id_text(message: Any) -> str:
    """A unique_identifier_msgs/UUID as the canonical text that `ros2 action send_goal` prints."""
    return str(uuid.UUID(bytes=bytes(message.uuid)))
