"""A bridge on a ROS domain of its own."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from dock_gateway.ros.bridge import Bridge


@pytest.fixture
async def bridge(domain: int, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Bridge]:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    bridge = Bridge("tested", "", 1_000_000)
    bridge.start()
    yield bridge
    await asyncio.to_thread(bridge.close)
