"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("camera_not_found", 404, "The robot has no camera of this name with a publisher."),
    ErrorCode("unreadable_picture", 502, "No picture of the camera can be shown: the detail says why."),
    ErrorCode("picture_unavailable", 503, "No picture of the camera has come within 5 s."),
)
