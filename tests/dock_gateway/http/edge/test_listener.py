"""Accepting connections: many in a turn of the loop, and again after the process had no files left."""

import asyncio
import os
import resource
import socket
from collections.abc import Iterator

import pytest

from dock_gateway.http.edge.listener import Opener, PortListener
from tests.support.waiting import until


class Counter(asyncio.Protocol):
    """Counts in which turn of the loop connections were made."""

    turn = 0

    def __init__(self, turns: list[int]) -> None:
        self._turns = turns

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._turns.append(Counter.turn)
        transport.close()


def opener(turns: list[int]) -> Opener:
    loop = asyncio.get_running_loop()
    return lambda sock: loop.connect_accepted_socket(lambda: Counter(turns), sock)


@pytest.fixture
def file_limit() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


async def test_many_connections_are_accepted_in_one_turn() -> None:
    listener = PortListener("127.0.0.1", 0)
    clients = [socket.create_connection(listener.sockets[0].getsockname()) for _ in range(100)]
    turns: list[int] = []
    listener.start(opener(turns))
    async with asyncio.timeout(10):
        while len(turns) < len(clients):
            Counter.turn += 1
            await asyncio.sleep(0)
    assert len(set(turns)) <= 10
    listener.close()
    for client in clients:
        client.close()


async def test_it_goes_on_after_the_files_were_used_up(file_limit: None, caplog: pytest.LogCaptureFixture) -> None:
    listener = PortListener("127.0.0.1", 0)
    turns: list[int] = []
    with socket.create_connection(listener.sockets[0].getsockname()):
        _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        listener.start(opener(turns))
        os.close(next_file := os.dup(0))
        resource.setrlimit(resource.RLIMIT_NOFILE, (next_file, hard))
        await asyncio.sleep(0.3)
        assert not turns
        assert "no connection can be accepted" in caplog.text
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        await until(lambda: bool(turns))
    listener.close()


async def test_an_address_that_is_taken() -> None:
    listener = PortListener("127.0.0.1", 0)
    with pytest.raises(OSError, match="in use"):
        PortListener("127.0.0.1", listener.sockets[0].getsockname()[1])
    listener.close()
    assert not listener.sockets


async def test_every_address_of_a_name() -> None:
    listener = PortListener("localhost", 0)
    families = {one.family for one in listener.sockets}
    assert socket.AF_INET in families
    assert all(one.getsockname()[0] in ("127.0.0.1", "::1") for one in listener.sockets)
    listener.close()
