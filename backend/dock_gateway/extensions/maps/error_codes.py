"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (ErrorCode("map_not_found", 404, "There is no map of the robot; the detail says why."),)
