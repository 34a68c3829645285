"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("picture_not_found", 404, "The recording has no picture of a camera that can be shown."),
    ErrorCode("recording_not_found", 404, "The goal has no recording; the detail says why."),
)
