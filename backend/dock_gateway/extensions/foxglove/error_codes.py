"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("subprotocol_required", 400, "The WebSocket does not ask for a subprotocol of Foxglove."),
    ErrorCode("channel_not_found", 404, "There is no such channel on this connection."),
    ErrorCode("channel_exists", 409, "This connection already publishes on a channel with this id."),
    ErrorCode("goal_running", 409, "The result was asked for of a goal that still runs: ask again."),
)
