"""The error codes of this extension."""

from dock_gateway.core.error_codes import ErrorCode

CODES = (
    ErrorCode(
        "login_failed",
        401,
        "A login with the identity provider was not started in this browser, was used, took too long or was refused.",
    ),
    ErrorCode("person_not_found", 404, "No person of this name is logged in."),
    ErrorCode("provider_not_found", 404, "No identity provider is configured for people."),
    ErrorCode(
        "provider_unavailable",
        503,
        "The identity provider does not answer, or its answer is invalid: the detail names the error.",
    ),
)
