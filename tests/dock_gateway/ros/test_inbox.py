"""The way of messages to the loop: in order, bounded, in turn, in portions."""

import asyncio
import threading
import time
from collections.abc import Callable
from functools import partial

import pytest

from dock_gateway.ros.inbox import MAX_BYTES, MAX_MESSAGES, Inbox, Inboxes
from tests.support.waiting import until


@pytest.fixture
async def inboxes() -> Inboxes:
    return Inboxes(asyncio.get_running_loop().call_soon_threadsafe)


def nothing_is_dropped(*_: object) -> None:
    raise AssertionError


async def in_thread(work: Callable[[], object]) -> None:
    await asyncio.wait_for(asyncio.to_thread(work), 30)


async def test_messages_come_in_order(inboxes: Inboxes) -> None:
    heard: list[int] = []
    inbox = Inbox(inboxes, nothing_is_dropped)

    def send() -> None:
        for number in range(100):
            inbox.put(heard.append, 2 * number)
            inbox.offer(10, heard.append, 2 * number + 1)

    await in_thread(send)
    await until(lambda: len(heard) == 200)
    assert heard == list(range(200))


@pytest.mark.parametrize(("size", "kept"), [(1, MAX_MESSAGES), (MAX_BYTES // 4, 4)])
async def test_of_too_much_the_oldest_is_dropped_and_counted(inboxes: Inboxes, size: int, kept: int) -> None:
    heard: list[int] = []
    dropped: list[int] = []
    inbox = Inbox(inboxes, dropped.append)
    for number in range(kept + 5):  # while the loop does something else
        inbox.offer(size, heard.append, number)
    await until(lambda: len(heard) == kept)
    assert dropped == [0, 1, 2, 3, 4]
    assert heard == list(range(5, kept + 5))


async def test_one_message_that_is_larger_than_all_room_is_not_dropped(inboxes: Inboxes) -> None:
    heard: list[str] = []
    Inbox(inboxes, nothing_is_dropped).offer(2 * MAX_BYTES, heard.append, "large")
    await until(lambda: heard == ["large"])


async def test_what_must_arrive_waits_for_room(inboxes: Inboxes) -> None:
    heard: list[int] = []
    inbox = Inbox(inboxes, nothing_is_dropped, max_messages=5, wait_for_room=30.0)

    def send() -> None:
        for number in range(50):
            inbox.put(heard.append, number)

    await in_thread(send)
    await until(lambda: len(heard) == 50)
    assert heard == list(range(50))


async def test_a_loop_that_does_not_come_back_holds_nobody_for_long(inboxes: Inboxes) -> None:
    inbox = Inbox(inboxes, nothing_is_dropped, max_messages=5)
    thread = threading.Thread(target=lambda: [inbox.put(int) for _ in range(7)])
    thread.start()
    thread.join(10)  # the loop does nothing meanwhile
    assert not thread.is_alive()


async def test_sources_take_turns_and_the_loop_goes_on(inboxes: Inboxes) -> None:
    flood, other = Inbox(inboxes, nothing_is_dropped), Inbox(inboxes, nothing_is_dropped)
    heard: list[str] = []

    def take(name: str) -> None:
        heard.append(name)
        time.sleep(0.001)

    for _ in range(200):
        flood.put(partial(take, "flood"))
    other.put(take, "other")
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert "other" in heard[:2]
    assert len(heard) < 100, "the loop has other work, too"
    await until(lambda: len(heard) == 201)


async def test_a_message_that_fails_harms_no_other(inboxes: Inboxes) -> None:
    heard: list[int] = []
    inbox = Inbox(inboxes, nothing_is_dropped)
    inbox.put(lambda: 1 // 0)
    inbox.put(heard.append, 1)
    await until(lambda: heard == [1])
