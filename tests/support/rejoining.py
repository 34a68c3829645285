"""The fault after which an action server is reached through another DDS participant."""

from typing import Any

import pytest

from dock_gateway.ros.bridge import Bridge


def lose_answers(bridge: Bridge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing that servers answer reaches this participant."""

    def take(client: Any) -> bool:
        return client.handle.take_response(client.srv_type.Response)[0] is not None

    monkeypatch.setattr(bridge._answers, "_take", take)  # noqa: SLF001 - DDS loses nothing on demand
