"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("webhook_not_found", 404, "There is no webhook with this id."),
    ErrorCode("test_running", 409, "Another test is being sent to this webhook."),
)
