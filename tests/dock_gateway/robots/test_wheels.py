"""Zero velocity is repeated, and left to others who drive."""

import asyncio

import pytest

from dock_gateway.robots.wheels import Wheels
from robot_io.halt import REPEATS

PERIOD = 0.001
LONG = 0.2


class Port:
    def __init__(self) -> None:
        self.zeros = self.failures = 0

    def publish_zero(self) -> None:
        if self.failures:
            self.failures -= 1
            raise RuntimeError("is changing its type")
        self.zeros += 1


async def test_each_zero_is_repeated() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    wheels.publish_zero()
    assert port.zeros == 1
    await asyncio.sleep(LONG)
    assert port.zeros == 1 + REPEATS


async def test_zeros_that_overlap_are_repeated_once() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    for _ in range(5):
        wheels.publish_zero()
    await asyncio.sleep(LONG)
    assert port.zeros == 5 + REPEATS


async def test_one_that_fails_is_repeated_all_the_same() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    port.failures = 3
    with pytest.raises(RuntimeError):
        wheels.publish_zero()
    await asyncio.sleep(LONG)
    assert port.zeros == REPEATS - 2


async def test_the_wheels_are_left_to_who_drives_next() -> None:
    for leave in (lambda wheels: wheels.leave(), lambda wheels: wheels.hear(True, b"another")):
        wheels = Wheels(port := Port(), period=PERIOD)
        wheels.publish_zero()
        leave(wheels)
        await asyncio.sleep(LONG)
        assert port.zeros == 1
        wheels.publish_zero()
        await asyncio.sleep(LONG)
        assert port.zeros == 2 + REPEATS


async def test_a_zero_of_others_changes_nothing() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    wheels.publish_zero()
    wheels.hear(False, b"another")
    await asyncio.sleep(LONG)
    assert port.zeros == 1 + REPEATS
