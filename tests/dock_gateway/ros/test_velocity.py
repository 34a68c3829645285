"""Zero velocity reaches every base, whichever type it subscribes to."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from geometry_msgs.msg import PoseStamped, Twist

from dock_gateway.core.graph import Endpoint, Quality, Topic
from dock_gateway.core.velocity_types import choose_types
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import scan
from dock_gateway.ros.velocity import VelocityPort, VelocityTopics
from robot_io.velocity_types import PLAIN, STAMPED
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, ros_environment

QUALITY = Quality("reliable", "volatile", "keep_last", 10, None, None, "automatic")
GATEWAY, OTHER_GATEWAY, BASE, SERVER = "/dock_gateway", "/other_gateway", "/base", "/dock_server"
WRENCH = "geometry_msgs/msg/Wrench"


def endpoints(*pairs: tuple[str, str]) -> list[Endpoint]:
    return [Endpoint(node, kind, QUALITY) for node, kind in pairs]


@pytest.mark.parametrize(
    ("publishers", "subscribers", "before", "types"),
    [
        ([], [], (PLAIN,), (PLAIN,)),
        ([], [], (STAMPED,), (STAMPED,)),
        ([(GATEWAY, PLAIN)], [(BASE, STAMPED)], (PLAIN,), (STAMPED,)),
        ([(GATEWAY, STAMPED)], [(BASE, PLAIN)], (STAMPED,), (PLAIN,)),
        ([(GATEWAY, PLAIN)], [(BASE, PLAIN), ("/second", STAMPED)], (PLAIN,), (PLAIN, STAMPED)),
        ([(GATEWAY, STAMPED)], [(BASE, PLAIN), ("/second", STAMPED)], (STAMPED,), (STAMPED, PLAIN)),
        # What another gateway and we ourselves listen to is no base.
        ([(OTHER_GATEWAY, PLAIN)], [(OTHER_GATEWAY, PLAIN), (BASE, STAMPED)], (PLAIN,), (STAMPED,)),
        ([(SERVER, STAMPED)], [(GATEWAY, PLAIN)], (PLAIN,), (STAMPED,)),
        ([(SERVER, STAMPED), ("/joystick", PLAIN)], [], (PLAIN,), (PLAIN,)),
        ([(SERVER, WRENCH)], [], (PLAIN,), ()),
        ([(SERVER, WRENCH), (GATEWAY, PLAIN)], [(GATEWAY, PLAIN)], (PLAIN,), ()),
        ([(SERVER, WRENCH), (OTHER_GATEWAY, PLAIN)], [], (PLAIN,), ()),
        ([(SERVER, WRENCH), ("/joystick", STAMPED)], [], (PLAIN,), (STAMPED,)),
        ([], [], (), (PLAIN,)),
        ([], [(BASE, STAMPED)], (), (STAMPED,)),
        ([], [(BASE, STAMPED), ("/logger", WRENCH)], (PLAIN,), (STAMPED,)),
    ],
)
def test_the_types_are_those_of_the_bases(
    publishers: list[tuple[str, str]],
    subscribers: list[tuple[str, str]],
    before: tuple[str, ...],
    types: tuple[str, ...],
) -> None:
    topic = Topic("/cmd_vel", endpoints(*publishers), endpoints(*subscribers))
    assert choose_types(topic, before, GATEWAY, [OTHER_GATEWAY]) == (types, None)


def test_a_base_of_an_unknown_type_is_a_fault() -> None:
    types, fault = choose_types(Topic("/cmd_vel", [], endpoints((BASE, WRENCH))), (PLAIN,), GATEWAY)
    assert types == ()
    assert fault is not None
    assert BASE in fault
    assert WRENCH in fault


class Robot:
    """The gateway's ports at a velocity topic, and the graph as it scans it."""

    def __init__(self, bridge: Bridge, topics: VelocityTopics | None = None) -> None:
        self.heard: list[bytes] = []
        self._bridge = bridge
        self.topics = topics or VelocityTopics(bridge)

    async def join(self) -> None:
        self.port = await self._bridge.call(lambda: VelocityPort(self.topics, "/cmd_vel", "/stop_latched"))
        self.listener = await self._bridge.call(
            lambda: self.topics.listen("/cmd_vel", lambda message, _: self.heard.append(message))
        )

    async def stop_until(self, holds: Callable[[], object]) -> None:
        """Look at the graph and stop, again and again, until something has come of it."""

        async def stopped() -> bool:
            found = await self._bridge.call(lambda: scan(self._bridge.node))
            await self.topics.update(found.topics)
            try:
                self.port.publish_zero()
            except RuntimeError as error:
                self.error = str(error)
            await asyncio.sleep(0.05)
            return bool(holds())

        for _ in range(600):
            if await stopped():
                return
        raise AssertionError("not stopped")

    def heard_of(self, speed: float) -> bool:
        return any(f'"x":{speed}'.encode() in message for message in self.heard)


@contextmanager
def running_base(domain: int, name: str, speed: float) -> Iterator[Callable[[], int]]:
    """A base, `stamped` or `plain`, and its driver; yields how often the base was stopped."""
    command = "-m", "tests.support.base", name, str(speed)
    with ForkedProcess(*command, env=ros_environment(domain)) as base:
        yield lambda: base.output.count("stopped")
        assert "no stamp" not in base.output


@pytest.mark.ros
async def test_who_watches_through_the_gateway_is_no_base_that_was_found(bridge: Bridge, domain: int) -> None:
    robot = Robot(bridge)
    await robot.join()
    assert robot.port.subscribers == 0
    with running_base(domain, "plain", 0.25) as plain:
        await robot.stop_until(plain)
        assert robot.port.subscribers == 1
        await bridge.call(robot.listener.close)
        assert robot.port.subscribers == 1
    await bridge.call(robot.port.close)


@pytest.mark.ros
async def test_a_listener_whose_thread_is_busy_when_it_is_closed_is_no_base_either(
    bridge: Bridge, observer: Observer
) -> None:
    hears, turn = threading.Event(), threading.Event()

    def hear(*_: object) -> None:
        hears.set()
        turn.wait(30.0)

    topics = VelocityTopics(bridge)
    port = await bridge.call(lambda: VelocityPort(topics, "/cmd_vel", "/stop_latched"))
    listener = await bridge.call(lambda: topics.watch("/cmd_vel", hear))
    try:
        while not hears.is_set():
            observer.publish(Twist(), "/cmd_vel")
            await asyncio.sleep(0.05)
        await bridge.call(listener.close)
        assert port.subscribers == 0
    finally:
        turn.set()
    for _ in range(20):
        await asyncio.sleep(0.01)
        assert port.subscribers == 0
    await bridge.call(port.close)


@pytest.mark.ros
async def test_a_stop_follows_the_base_from_type_to_type_and_all_drivers_are_heard(bridge: Bridge, domain: int) -> None:
    robot = Robot(bridge)
    await robot.join()
    with running_base(domain, "stamped", -0.25) as stamped:
        await robot.stop_until(lambda: stamped() and robot.heard_of(-0.25))
        assert robot.heard[-1].startswith(b'{"linear":{"x":')  # as a Twist, without a header
        with running_base(domain, "plain", 0.25) as plain:
            await robot.stop_until(lambda: plain() and robot.heard_of(0.25))
            before = stamped()
            robot.heard.clear()
            await robot.stop_until(lambda: stamped() > before and robot.heard_of(-0.25))
            assert robot.listener.complete
    await bridge.call(robot.listener.close)
    await bridge.call(robot.port.close)


@pytest.mark.ros
async def test_a_robot_that_leaves_a_topic_does_not_take_it_from_another_one(bridge: Bridge, domain: int) -> None:
    robot = Robot(bridge)
    other = Robot(bridge, robot.topics)
    await robot.join()
    await other.join()
    await bridge.call(other.listener.close)
    await bridge.call(other.port.close)
    with running_base(domain, "plain", 0.25) as plain:
        await robot.stop_until(lambda: plain() and robot.heard_of(0.25))
    await bridge.call(robot.port.close)
    await bridge.call(robot.listener.close)


@pytest.mark.ros
async def test_a_stop_that_no_base_can_hear_is_an_error(bridge: Bridge, observer: Observer) -> None:
    robot = Robot(bridge)
    await robot.join()
    robot.port.publish_zero()
    observer.record(PoseStamped, "/cmd_vel")
    robot.error = ""
    await robot.stop_until(lambda: "/observer as geometry_msgs/msg/PoseStamped" in robot.error)


@pytest.mark.ros
async def test_what_the_listener_has_no_turn_for_is_heard_on_the_loop(
    bridge: Bridge, domain: int, observer: Observer
) -> None:
    heard: list[float] = []
    turn = threading.Event()

    def hear(_motion: bool, _publisher: bytes, at: float) -> None:
        heard.append(at)
        if threading.current_thread() is not threading.main_thread():
            turn.wait(30.0)  # the listener's thread does not go on

    topics = VelocityTopics(bridge)
    listener = await bridge.call(lambda: topics.watch("/cmd_vel", hear))
    try:
        while not heard:
            observer.publish(Twist(), "/cmd_vel")
            await asyncio.sleep(0.05)
        listener.catch_up()  # those that were published meanwhile
        before, published_at = len(heard), time.monotonic()
        observer.publish(Twist(), "/cmd_vel")
        while len(heard) == before:
            await asyncio.sleep(0.2)
            listener.catch_up()
        assert published_at <= heard[-1] + 0.01
        assert heard[-1] < time.monotonic() - 0.1  # when it arrived, not when it was heard
    finally:
        turn.set()
    await bridge.call(listener.close)
