"""Requests without an application."""

from typing import Any

from starlette.requests import Request

from dock_gateway.audit.trail import Trail
from dock_gateway.core.access import ANYBODY
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings


def request(body: bytes, headers: list[tuple[bytes, bytes]] | None = None) -> Request:
    """A request to a gateway that has only settings."""

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": body, "more_body": False}

    state = {"parts": Parts({Settings: Settings()})}
    scope = {"type": "http", "headers": headers or [], "state": state, "principal": ANYBODY}
    return Request(scope | {"audit": Trail(scope)}, receive)
