"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("rule_not_found", 404, "There is no rule of automatic docking with this id."),
    ErrorCode("interrupted", None, "Of a decision: the gateway ended before the goal was sent."),
)
