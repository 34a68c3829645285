"""However connections come and go, none of them leaves a subscriber behind: 1,000 of those shut everybody out."""

import asyncio
import random
from collections.abc import Iterator

import httpx2
import orjson
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from tests.support.gateway import CHARGING, RunningGateway, ready_gateway
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

READERS = 150


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with ready_gateway(shared_domain) as gateway:
        yield gateway


@pytest.fixture(scope="module")
def goal_id(gateway: RunningGateway) -> str:
    """A goal that has ended: who asks for it waits for the history."""
    gateway.publish(CHARGING)
    goal = gateway.http.post("/dock", headers={"Prefer": "wait=50"}).raise_for_status().json()
    assert goal["status"] == "succeeded"
    identity: str = goal["goal_id"]
    return identity


async def use_a_socket(gateway: RunningGateway, goal_id: str, choose: random.Random) -> None:
    """Send commands, without waiting for answers, and leave at any moment, politely or not."""
    commands = [
        {"op": "subscribe", "id": "a", "goal_id": goal_id},
        {"op": "subscribe", "id": "a", "include": ["battery", "scene", "robots"]},
        {"op": "subscribe", "id": "b", "goal_id": goal_id},
        {"op": "unsubscribe", "subscription": "a"},
        {"op": "ping"},
    ]
    async with connect(f"{gateway.url.replace('http', 'ws')}/ws") as socket:
        for command in choose.choices(commands, [4, 1, 2, 1, 1], k=choose.randint(1, 8)):
            await socket.send(orjson.dumps(command).decode())
        await read_or_leave(socket, choose)


async def read_along(gateway: RunningGateway, path: str, choose: random.Random) -> None:
    async with connect(f"{gateway.url.replace('http', 'ws')}{path}") as socket:
        await read_or_leave(socket, choose)


async def read_or_leave(socket: connect, choose: random.Random) -> None:
    try:
        async with asyncio.timeout(choose.choice([0, 0.001, 0.005, 0.02, 0.1])):
            while True:
                await socket.recv()
    except (TimeoutError, ConnectionClosed):
        if choose.random() < 0.5:
            socket.transport.abort()


async def read_server_sent_events(gateway: RunningGateway, goal_id: str, choose: random.Random) -> None:
    async with httpx2.AsyncClient(base_url=gateway.url, trust_env=False) as http:
        try:
            async with asyncio.timeout(choose.choice([0.002, 0.005, 0.02, 0.1])):
                await http.get(f"/dock/{goal_id}/events")
        except TimeoutError:
            pass


@pytest.mark.parametrize("seed", range(2))
async def test_none_is_left_behind(gateway: RunningGateway, goal_id: str, seed: int) -> None:
    choose = random.Random(seed)
    running = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
    ways = [
        lambda: use_a_socket(gateway, goal_id, choose),
        lambda: read_along(gateway, f"/ws/feedback?goal_id={goal_id}", choose),
        lambda: read_along(gateway, "/ws/feedback?include=scene", choose),
        lambda: read_along(gateway, "/ws/topics?topic=/battery_status", choose),
        lambda: read_server_sent_events(gateway, goal_id, choose),
        lambda: read_server_sent_events(gateway, running, choose),
    ]
    at_once = asyncio.Semaphore(10)

    async def use() -> None:
        async with at_once:
            await choose.choices(ways, [5, 1, 1, 1, 1, 1])[0]()

    await asyncio.gather(*(use() for _ in range(READERS)))
    wait_until(lambda: gateway.http.get("/healthz").json()["subscribers"] == 0, "no subscriber at all")
    assert "Traceback" not in gateway.process.output
