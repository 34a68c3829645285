"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode(
        "simulator_not_found", 404, "The robot is not simulated, or its simulator has been silent for several seconds."
    ),
    ErrorCode("simulator_timeout", 504, "The simulator did not answer within 4 s."),
)
