"""The publisher of battery states: what cannot be published changes nothing. tests/system has a real topic."""

from collections.abc import AsyncIterator
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.hub import Hub
from dock_gateway.robots.battery import BatteryPublisher
from tests.support.waiting import until


class Port:
    """Notes the voltages that are published; `down` refuses them."""

    def __init__(self) -> None:
        self.published: list[float] = []
        self.down = False
        self.codec = SimpleNamespace(parse=self._parse)

    def _parse(self, value: float, _: str) -> Any:
        return SimpleNamespace(voltage=value, header=SimpleNamespace(stamp=SimpleNamespace(sec=1, nanosec=0)))

    async def publish(self, message: Any, *, stamp: bool) -> bytes:
        if self.down:
            raise Unavailable("the ROS thread does not answer", code="ros_unavailable")
        self.published.append(message.voltage)
        return b'{"voltage":%g}' % message.voltage


@pytest.fixture
def port() -> Port:
    return Port()


@pytest.fixture
async def publisher(port: Any) -> AsyncIterator[BatteryPublisher]:
    publisher = BatteryPublisher(port, Hub(queue_limit=10, max_subscribers=10), "/robot1")
    yield publisher
    await publisher.stop()


async def test_one_that_cannot_begin_leaves_the_one_before(publisher: BatteryPublisher, port: Port) -> None:
    await publisher.start(8.0, 100.0)
    port.down = True
    with pytest.raises(Unavailable):
        await publisher.start(9.0, 100.0)
    port.down = False
    assert (publisher.active, publisher.document()["rate_hz"]) == (True, 100.0)
    so_far = len(port.published)
    await until(lambda: len(port.published) > so_far)
    assert set(port.published) == {8.0}


async def test_a_second_one_replaces_the_first(publisher: BatteryPublisher, port: Port) -> None:
    await publisher.start(8.0, 100.0)
    await publisher.start(9.0, 100.0)
    so_far = len(port.published)
    await until(lambda: len(port.published) > so_far + 1)
    assert set(port.published[so_far:]) == {9.0}
    await publisher.stop()
    assert not publisher.active
