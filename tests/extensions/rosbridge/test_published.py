"""A message is encoded once for all clients, and a large one in another process: the bytes are the same."""

import asyncio
from collections.abc import AsyncIterator

import numpy as np
import orjson
import pytest
from nav_msgs.msg import OccupancyGrid, Path
from rclpy.serialization import serialize_message

from dock_gateway.core.work import MEDIUM, MOST, SMALL, TooLarge, Work
from dock_gateway.extensions.rosbridge.encoding import encode
from dock_gateway.extensions.rosbridge.protocol import Compression
from dock_gateway.extensions.rosbridge.published import Published
from dock_gateway.graph.received import Received
from dock_gateway.ros.raw_port import Arrival, EchoType
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.timeout(PATIENCE)
NOW = 1_700_000_000_123_456_789


@pytest.fixture
async def work() -> AsyncIterator[Work]:
    made = Work()
    yield made
    await made.close()


def grid(size: int) -> Received:
    message = OccupancyGrid()
    message.data.frombytes((np.arange(size) % 100).astype(np.int8).tobytes())
    return Received("/map", EchoType("nav_msgs/msg/OccupancyGrid"), Arrival(serialize_message(message), 1, NOW))


@pytest.mark.parametrize("size", [10, SMALL, MEDIUM])
@pytest.mark.parametrize("compression", Compression)
async def test_where_it_is_encoded_makes_no_difference(work: Work, compression: Compression, size: int) -> None:
    received = grid(size)
    payload = await Published(received).payload(compression, work)
    here = encode(compression, received.topic, received.kind.name, received.data, NOW)
    assert payload == here
    assert here.frame.endswith(here.data)
    assert here.size == len(here.data)
    if compression is Compression.none:
        assert orjson.loads(here.data)["msg"]["data"] == [each % 100 for each in range(size)]


async def test_it_is_encoded_once_for_all(work: Work) -> None:
    message = Published(grid(MEDIUM))
    first, *others = await asyncio.gather(*(message.payload(Compression.none, work) for _ in range(3)))
    assert all(each is first for each in others)


@pytest.mark.parametrize("size", [1, MEDIUM + 1])
async def test_bytes_of_another_type_are_no_message(work: Work, size: int) -> None:
    arrival = Arrival(b"\0\1\0\0" + b"\xff" * size, 1, NOW)
    message = Published(Received("/path", EchoType("nav_msgs/msg/Path"), arrival))
    assert await message.payload(Compression.none, work) is None


async def test_what_is_too_large_is_refused_unless_its_bytes_stay_as_they_are(work: Work) -> None:
    message = Published(grid(MOST))
    with pytest.raises(TooLarge):
        await message.payload(Compression.none, work)
    raw = await message.payload(Compression.cbor_raw, work)
    assert raw is not None
    assert raw.size > MOST


async def test_the_loop_goes_on_while_a_large_message_is_encoded(work: Work) -> None:
    """In a thread, decoding this message alone would keep the loop waiting for a tenth of a second."""
    path = Path()
    data = serialize_message(path)[:-4] + (20_000).to_bytes(4, "little") + bytes(72 * 20_000)
    await work(MEDIUM + 1, len, b"")  # the process has started
    message = Published(Received("/path", EchoType("nav_msgs/msg/Path"), Arrival(data, 1, NOW)))
    encoding = asyncio.create_task(message.payload(Compression.none, work))
    turns = 0
    while not encoding.done():
        await asyncio.sleep(0.001)
        turns += 1
    payload = await encoding
    assert payload is not None
    assert payload.size > len(data)
    assert turns > 20
