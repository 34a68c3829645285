"""Zero velocity is repeated, and left to others who drive."""

import asyncio
import time

import pytest

from dock_gateway.robots.wheels import VelocityCommand, Wheels
from robot_io.halt import REPEATS
from tests.support.waiting import until

PERIOD = 0.001
LONG = 0.2


class Port:
    def __init__(self) -> None:
        self.zeros = self.failures = 0
        self.subscribers = 1

    def publish_zero(self) -> None:
        if self.failures:
            self.failures -= 1
            raise RuntimeError("is changing its type")
        self.zeros += 1


async def publishes(port: Port, zeros: int) -> None:
    """Require that so many zeros are published, and no more."""
    await until(lambda: port.zeros >= zeros)
    await asyncio.sleep(LONG)
    assert port.zeros == zeros


async def test_each_zero_is_repeated() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    wheels.publish_zero()
    assert port.zeros == 1
    await publishes(port, 1 + REPEATS)


async def test_a_base_that_dds_finds_late_gets_zero_too() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    port.subscribers = 0
    wheels.publish_zero()
    await publishes(port, 1 + REPEATS)
    before = port.zeros
    port.subscribers = 1
    await publishes(port, before + 1 + REPEATS)


async def test_a_base_that_another_one_drives_by_then_gets_none() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    port.subscribers = 0
    wheels.publish_zero()
    await publishes(port, 1 + REPEATS)
    before = port.zeros
    wheels.hear(True, b"another", time.monotonic())
    port.subscribers = 1
    await publishes(port, before)


async def test_zeros_that_overlap_are_repeated_once() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    for _ in range(5):
        wheels.publish_zero()
    await publishes(port, 5 + REPEATS)


async def test_one_that_fails_is_repeated_all_the_same() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    port.failures = 3
    with pytest.raises(RuntimeError):
        wheels.publish_zero()
    await publishes(port, REPEATS - 2)


async def test_the_wheels_are_left_to_who_drives_next() -> None:
    for leave in (lambda wheels: wheels.leave(), lambda wheels: wheels.hear(True, b"another", time.monotonic())):
        wheels = Wheels(port := Port(), period=PERIOD)
        wheels.publish_zero()
        leave(wheels)
        await publishes(port, 1)
        wheels.publish_zero()
        await publishes(port, 2 + REPEATS)


async def test_a_zero_of_others_changes_nothing() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    wheels.publish_zero()
    wheels.hear(False, b"another", time.monotonic())
    await publishes(port, 1 + REPEATS)


async def test_a_motion_that_came_before_a_zero_and_is_heard_after_it_changes_nothing() -> None:
    wheels = Wheels(port := Port(), period=PERIOD)
    before = time.monotonic()
    wheels.publish_zero()
    wheels.hear(True, b"another", before)
    await publishes(port, 1 + REPEATS)


def test_commands_count_in_the_order_in_which_they_arrived() -> None:
    wheels = Wheels(Port())
    wheels.hear(False, b"server", 2.0)
    wheels.hear(True, b"server", 1.0)
    assert wheels.last == VelocityCommand(2.0, motion=False, publisher=b"server")


def test_the_usual_interval_is_that_of_the_node_that_moves_the_robot_while_it_does() -> None:
    wheels = Wheels(Port())
    for at in (0.0, 0.5, 1.0):
        wheels.hear(True, b"server", at)
        wheels.hear(False, b"gateway", at + 0.1)
    assert wheels.interval == 0.0  # not known yet
    wheels.hear(True, b"server", 1.5)
    assert wheels.interval == 0.5
    wheels.hear(False, b"server", 1.6)
    wheels.hear(True, b"server", 100.0)
    wheels.hear(True, b"server", 102.0)  # it stalled once
    assert wheels.interval == 0.5
    wheels.hear(True, b"another", 102.1)
    assert wheels.interval == 0.0
