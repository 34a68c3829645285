"""Whatever another thread does in the middle of what one does: after a stop the robot is not driven on."""

import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from types import FrameType
from typing import Any

import pytest

from docking.core.observation import STANDSTILL, Velocity
from docking.ros import velocity
from docking.ros.velocity import Drive

FORWARD = Velocity(0.1, 0.0)
BRIEFLY = 0.02
"""Seconds that the other thread has in the middle of the first one; where a lock keeps it out, it acts later."""


class Publisher:
    def __init__(self, _node: object) -> None:
        self.sent: list[Velocity] = []

    def publish(self, sent: Velocity) -> None:
        self.sent.append(sent)

    def close(self) -> None:
        pass


class Others:
    heard_at = float("-inf")

    def __init__(self, _node: object) -> None:
        pass

    def leave(self) -> None:
        pass


class Timer:
    def reset(self) -> None:
        pass

    def cancel(self) -> None:
        pass


class Node:
    def create_timer(self, *_: object, **_options: object) -> Timer:
        return Timer()


class Asleep:
    """A watchdog without a thread: the test says when there is silence."""

    on_silence: Callable[[], None]

    def __init__(self, _timeout: float, on_silence: Callable[[], None]) -> None:
        Asleep.on_silence = staticmethod(on_silence)

    def feed(self, timeout: float | None = None) -> None:
        pass

    def sleep(self) -> None:
        pass


@pytest.fixture(autouse=True)
def parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(velocity, "VelocityPublisher", Publisher)
    monkeypatch.setattr(velocity, "OtherCommands", Others)
    monkeypatch.setattr(velocity, "Watchdog", Asleep)


def interrupt(first: Callable[[], None], other: Callable[[], None], line: int) -> bool:
    """Run `other` in a thread of its own before the nth line of this module that `first` runs.

    Returns:
        Whether `first` has as many lines.
    """
    thread = threading.Thread(target=other)
    seen = 0

    def trace(frame: FrameType, event: str, _argument: Any) -> Any:
        nonlocal seen
        if frame.f_code.co_filename != velocity.__file__:
            return None
        if event == "line":
            seen += 1
            if seen == line:
                thread.start()
                thread.join(BRIEFLY)
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        first()
    finally:
        sys.settrace(before)
    if thread.ident is not None:
        thread.join()
    return seen >= line


def every_interruption(
    before: Callable[[Drive], None], first: Callable[[Drive], None], other: Callable[[Drive], None]
) -> list[list[Velocity]]:
    """What is published, with the other thread before each line of the first one; all of them end a motion."""
    published = []
    for line in range(1, 100):
        drive = Drive(Node())
        before(drive)
        if not interrupt(partial(first, drive), partial(other, drive), line):
            return published
        published.append(sent(drive))
    raise AssertionError("it has no end")


def sent(drive: Drive) -> list[Velocity]:
    assert isinstance(drive.publisher, Publisher)
    return drive.publisher.sent


def go(drive: Drive) -> None:
    drive.go(FORWARD, time.monotonic())


@pytest.mark.parametrize("stop", [Drive.stop, Drive.hold_still])
def test_a_stop_from_another_thread_is_the_last_word(stop: Callable[[Drive], None]) -> None:
    halting = []

    def stop_and_look(drive: Drive) -> None:
        stop(drive)
        halting.append(drive)

    published = every_interruption(go, go, stop_and_look)
    assert len(published) > 5
    assert all(velocities[-1] == STANDSTILL for velocities in published)
    assert all(drive.halting for drive in halting)


def test_no_zero_is_repeated_once_the_wheels_were_left() -> None:
    def leave(drive: Drive) -> None:
        drive.leave()
        sent(drive).append(FORWARD)  # the next who drives

    published = every_interruption(Drive.stop, lambda _: Asleep.on_silence(), leave)
    assert len(published) > 5
    assert all(velocities[-1] == FORWARD for velocities in published)
