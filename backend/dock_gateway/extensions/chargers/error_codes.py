"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("shared_dock_not_found", 404, "There is no shared dock of this name."),
    ErrorCode("dock_not_for_robot", 409, "The shared dock is not one for this robot."),
    ErrorCode("dock_out_of_order", 409, "The shared dock is out of order: `detail` says why."),
)
