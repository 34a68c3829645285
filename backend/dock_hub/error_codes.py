"""The error codes of a hub."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode("site_not_found", 404, "There is no site of that name, or the limits leave it out.", "access.md#limits"),
    ErrorCode("release_incomplete", 504, "Not every site has confirmed the release; `sites` says which has."),
    ErrorCode("stop_incomplete", 504, "Not every site has confirmed the stop; `sites` says which has."),
    ErrorCode("stopped_again", 409, "A stop of the same site was asked for while the release waited. The stop holds."),
)
