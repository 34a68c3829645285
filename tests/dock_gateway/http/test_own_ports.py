"""Ports on which `/` is another path."""

import pytest
from starlette.types import Receive, Scope, Send

from dock_gateway.http.own_ports import OwnPorts

KEY = [(b"sec-websocket-key", b"x")]


async def path_of(scope: Scope) -> str:
    """The path that the application gets."""
    paths = []

    async def app(scope: Scope, _: Receive, __: Send) -> None:
        paths.append(scope["path"])

    await OwnPorts(app, {9090: "/rosbridge", 8765: "/foxglove"})(
        {"server": ("127.0.0.1", 9090), "headers": [], **scope}, None, None
    )  # type: ignore[arg-type]
    return str(paths[0])


@pytest.mark.parametrize(
    ("scope", "path"),
    [
        ({"type": "websocket", "path": "/"}, "/rosbridge"),
        ({"type": "websocket", "path": "/", "server": ("::1", 8765)}, "/foxglove"),
        ({"type": "websocket", "path": "/ws"}, "/ws"),
        ({"type": "websocket", "path": "/", "server": ("127.0.0.1", 8000)}, "/"),
        ({"type": "http", "path": "/"}, "/"),
        ({"type": "http", "path": "/", "headers": KEY}, "/rosbridge"),  # a proxy has not passed the upgrade on
        ({"type": "http", "path": "/dock", "headers": KEY}, "/dock"),
    ],
)
async def test_whose_root_is_another_path(scope: Scope, path: str) -> None:
    assert await path_of(scope) == path
