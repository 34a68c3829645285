"""Answers to input that never becomes a request to the application."""

from email.utils import formatdate
from http import HTTPStatus

from dock_gateway.core.errors import GatewayError, MalformedRequest
from dock_gateway.core.goal import encode
from dock_gateway.http.edge.security import security_headers

MEDIA_TYPE = "application/problem+json"
CODES = {
    HTTPStatus.REQUEST_TIMEOUT: "request_timeout",
    HTTPStatus.REQUEST_URI_TOO_LONG: "header_too_large",
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: "header_too_large",
}


def refusal(status: HTTPStatus, detail: str) -> GatewayError:
    """Return the error for input that is not a request."""
    return MalformedRequest(detail, code=CODES.get(status, "malformed_request"), status=status)


def refusal_headers(body: bytes, *, tls: bool) -> dict[str, str]:
    """Return the headers of an answer after which the connection is closed."""
    return {
        "Date": formatdate(usegmt=True),
        "Connection": "close",
        "Content-Type": MEDIA_TYPE,
        "Content-Length": str(len(body)),
        **security_headers(tls=tls),
    }


def http_answer(error: GatewayError, *, tls: bool) -> bytes:
    """Return a complete HTTP answer for an error."""
    body = encode(error.problem())
    status = HTTPStatus(error.status)
    headers = "".join(f"{name}: {value}\r\n" for name, value in refusal_headers(body, tls=tls).items())
    return f"HTTP/1.1 {status:d} {status.phrase}\r\n{headers}\r\n".encode() + body
