"""A watchdog acts once for each silence that is too long."""

import threading
import time
from collections.abc import Iterator

import pytest

from docking.ros.velocity import Watchdog

TIMEOUT = 0.1


class Alarm:
    def __init__(self) -> None:
        self.times: list[float] = []
        self.rang = threading.Event()

    def ring(self) -> None:
        self.times.append(time.monotonic())
        self.rang.set()


@pytest.fixture
def alarm() -> Alarm:
    return Alarm()


@pytest.fixture
def watchdog(alarm: Alarm) -> Iterator[Watchdog]:
    dog = Watchdog(TIMEOUT, alarm.ring)
    yield dog
    dog.close()


def test_it_acts_once_when_it_was_not_fed_in_time(watchdog: Watchdog, alarm: Alarm) -> None:
    for _ in range(2):
        alarm.rang.clear()
        fed_at = time.monotonic()
        watchdog.feed()
        assert alarm.rang.wait(10.0)
        assert alarm.times[-1] - fed_at >= TIMEOUT
    assert len(alarm.times) == 2


def test_it_acts_after_the_last_feeding_only(watchdog: Watchdog, alarm: Alarm) -> None:
    for _ in range(50):
        watchdog.feed()
    fed_at = time.monotonic()
    watchdog.feed()
    assert alarm.rang.wait(10.0)
    assert alarm.times[0] - fed_at >= TIMEOUT


def test_asleep_it_needs_no_food(watchdog: Watchdog, alarm: Alarm) -> None:
    watchdog.feed()
    watchdog.sleep()
    assert not alarm.rang.wait(3 * TIMEOUT)


def test_closed_it_has_no_thread(alarm: Alarm) -> None:
    dog = Watchdog(TIMEOUT, alarm.ring)
    dog.feed()
    dog.close()
    assert not any(thread.name == "watchdog" for thread in threading.enumerate())
    assert alarm.times == []
