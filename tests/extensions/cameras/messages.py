"""Messages of cameras as the gateway receives them."""

from types import SimpleNamespace
from typing import Any, cast

from dock_gateway.extensions.cameras.camera import COMPRESSED
from dock_gateway.graph.received import Received


def received(decoded: Any, kind: str = COMPRESSED, size: int = 100) -> Received:
    """A message that decodes to this; without it, one that cannot be read."""

    def decode(_: bytes) -> Any:
        if decoded is None:
            raise ValueError("no such bytes")
        return decoded

    message = SimpleNamespace(
        kind=SimpleNamespace(name=kind, decode=decode), data=b"", size=size, received_ns=1_700_000_000_250_000_000
    )
    return cast("Received", message)
