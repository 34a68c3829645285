"""Calls into the ROS thread: each one runs, or its caller is told that it did not, and then it never runs."""

import asyncio
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest
from geometry_msgs.msg import Twist
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from sensor_msgs.msg import BatteryState

from dock_gateway.core.errors import Unavailable
from dock_gateway.ros.action_port import ActionPort
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.robot_ports import BatteryPort
from dock_gateway.ros.ros_thread import MAX_CRASHES
from dock_gateway.ros.typed_topics import TypedTopics
from dock_gateway.ros.velocity import VelocityPort, VelocityTopics
from tests.support.observer import Observer
from tests.support.processes import ros_environment
from tests.support.waiting import until

pytestmark = pytest.mark.ros

DOCK_TYPE = "action_tutorials_interfaces/action/ConnectToChargingDock"


@contextmanager
def blocked(bridge: Bridge) -> Iterator[None]:
    """The ROS thread does nothing while the block runs."""
    released = threading.Event()
    bridge.to_ros(lambda: released.wait(30))
    try:
        yield
    finally:
        released.set()


async def test_a_call_that_was_given_up_never_runs(bridge: Bridge) -> None:
    ran: list[str] = []
    with blocked(bridge):
        with pytest.raises(Unavailable) as refused:
            await bridge.call(lambda: ran.append("given up"), timeout=0.05)
        assert refused.value.code == "ros_unavailable"
        canceled = asyncio.create_task(bridge.call(lambda: ran.append("canceled")))
        await asyncio.sleep(0)
        canceled.cancel()
        with pytest.raises(asyncio.CancelledError):
            await canceled
    await bridge.call(lambda: ran.append("next"))
    assert ran == ["next"]


async def test_calls_run_in_order(bridge: Bridge) -> None:
    ran: list[int] = []
    with blocked(bridge):
        for number in range(20):
            bridge.to_ros(partial(ran.append, number))
    await bridge.call(lambda: None)
    assert ran == list(range(20))


async def test_a_call_that_has_begun_is_waited_for(bridge: Bridge) -> None:
    begun, released = threading.Event(), threading.Event()

    def work() -> str:
        begun.set()
        released.wait(30)
        return "done"

    call = asyncio.create_task(bridge.call(work, timeout=1.0))
    await asyncio.to_thread(begun.wait, 10)
    asyncio.get_running_loop().call_later(1.1, released.set)
    assert await call == "done"


async def test_what_comes_of_a_call_too_late_is_undone(bridge: Bridge) -> None:
    undone: list[str] = []
    released = threading.Event()

    def make() -> str:
        released.wait(30)
        return "port"

    with pytest.raises(Unavailable):
        await bridge.call(make, timeout=0.05, undo=undone.append)
    assert undone == []
    released.set()
    await until(lambda: bool(undone))
    assert undone == ["port"]


async def test_what_comes_of_a_call_while_the_bridge_closes_goes_with_it(
    bridge: Bridge, caplog: pytest.LogCaptureFixture
) -> None:
    begun, released = threading.Event(), threading.Event()
    errors: list[dict[str, object]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: errors.append(context))

    def make() -> str:
        begun.set()
        released.wait(30)
        return "port"

    call = asyncio.create_task(bridge.call(make, undo=lambda _: None))
    await asyncio.to_thread(begun.wait, 10)
    call.cancel()
    closing = bridge.close_soon()
    await until(lambda: not bridge.alive)
    released.set()
    await asyncio.to_thread(closing.join, 10)
    bridge.to_ros(lambda: None)
    await asyncio.sleep(0)
    assert errors == []
    assert caplog.records == []


async def test_a_call_that_fails_says_why(bridge: Bridge) -> None:
    with pytest.raises(ZeroDivisionError):
        await bridge.call(lambda: 1 // 0)


async def test_a_battery_state_answered_with_503_is_not_published_later(bridge: Bridge, observer: Observer) -> None:
    heard = observer.record(BatteryState, "/battery_status")
    port = await bridge.call(
        lambda: BatteryPort(TypedTopics(bridge), "/battery_status", lambda *_: None, "/stop_latched")
    )
    while not heard.messages:  # the observer is not found yet
        await port.publish(BatteryState(voltage=1.0), stamp=False)
        await asyncio.sleep(0.1)
    with blocked(bridge), pytest.raises(Unavailable):
        await port.publish(BatteryState(voltage=2.0), stamp=False)
    await port.publish(BatteryState(voltage=3.0), stamp=False)
    await asyncio.to_thread(heard.wait_for, lambda message: message.voltage == 3)
    assert list(dict.fromkeys(message.voltage for message in heard.messages)) == [1, 3]


async def test_zero_velocity_does_not_wait_for_the_ros_thread(bridge: Bridge, observer: Observer) -> None:
    heard = observer.record(Twist, "/cmd_vel")
    port = await bridge.call(lambda: VelocityPort(VelocityTopics(bridge), "/cmd_vel", "/stop_latched"))

    def stopped() -> bool:
        port.publish_zero()
        return bool(heard.messages)

    with blocked(bridge):
        await until(stopped)


async def test_requests_on_which_rclpy_raises_do_not_end_the_ros_thread(bridge: Bridge, observer: Observer) -> None:
    odd = SetParameters.Request(parameters=[Parameter(name="any", value=ParameterValue(type=42))])
    for _ in range(MAX_CRASHES + 1):
        answer = await asyncio.to_thread(observer.request, SetParameters, "/tested/set_parameters", odd)
        assert not answer.results
    assert bridge.alive


async def test_a_port_that_nobody_waits_for_any_more_is_never_made(bridge: Bridge) -> None:
    def make() -> ActionPort:
        port = ActionPort(bridge, "/dock", DOCK_TYPE)
        port.listen(lambda *_: None, lambda *_: None, lambda *_: None)
        return port

    def entities() -> int:
        return len(list(bridge.node.subscriptions)) + len(list(bridge.node.clients))

    before = await bridge.call(entities)
    with blocked(bridge), pytest.raises(Unavailable):
        await bridge.call(make, timeout=0.05, undo=ActionPort.close)
    assert await bridge.call(entities) == before


# Prints whether sockets wait to send, those from which a participant sends: the others are bound to DDS's known ports.
SENDERS = """
import asyncio, os, pathlib
from dock_gateway.ros.bridge import Bridge

async def main():
    bridge = Bridge("tested", "", 1000)
    table = [line.split() for line in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:]]
    ports = {f"socket:[{row[9]}]": int(row[1].split(":")[1], 16) for row in table}
    for descriptor in os.listdir("/proc/self/fd"):
        path = f"/proc/self/fd/{descriptor}"
        if os.path.islink(path) and ports.get(os.readlink(path), 0) > 32_767:
            print("waits" if os.get_blocking(int(descriptor)) else "does not wait")
    bridge.close()

asyncio.run(main())
"""


def test_nothing_waits_to_send_to_a_robot_that_is_unreachable(domain: int) -> None:
    alone = ("unshare", "--map-root-user", "--net", "sh", "-c")
    up = "ip link set lo up"
    if shutil.which("unshare") is None or subprocess.run((*alone, up), check=False, capture_output=True).returncode:
        pytest.skip("no network of its own can be had")
    inside = f"{up} && exec {sys.executable} -c '{SENDERS}'"
    environment = ros_environment(domain, ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET")  # a network that nobody else is in
    done = subprocess.run((*alone, inside), env=environment, capture_output=True, text=True, check=True, timeout=60)
    assert set(done.stdout.split("\n")) - {""} == {"does not wait"}


async def test_ros_that_does_not_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"ENABLE": "true", "STRATEGY": "Enforce", "KEYSTORE": str(tmp_path)}.items():
        monkeypatch.setenv(f"ROS_SECURITY_{name}", value)
    with pytest.raises(Unavailable, match=f"ROS does not start: .*{tmp_path}/enclaves"):
        Bridge("gateway", "", 10_000)
