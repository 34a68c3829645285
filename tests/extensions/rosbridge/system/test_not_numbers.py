"""NaN and Infinity as Python's `json` writes them are read at `/rosbridge`, as nowhere else."""

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import BatteryState, LaserScan
from std_msgs.msg import Float64
from websockets.sync.client import ClientConnection

from tests.support.clients import open_websocket
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.observer import Observer, ros_observer
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

SCAN, BATTERY, NUMBER = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/BatteryState", "std_msgs/msg/Float64"
TOPICS = {"/readings": SCAN, "/measured": BATTERY, "/number": NUMBER}
TWISTS = {"/cmd_vel": "geometry_msgs/msg/Twist", "/cmd_vel_stamped": "geometry_msgs/msg/TwistStamped"}
NAN, INF = math.nan, math.inf


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with (
        running_program(shared_domain, "fibonacci_action_server"),
        running_gateway(
            shared_domain, allow_publish=",".join([*TOPICS, *TWISTS]), allow_parameters="/fibonacci*"
        ) as gateway,
    ):
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        yield gateway


@pytest.fixture(scope="module")
def observer(shared_domain: int) -> Iterator[Observer]:
    with ros_observer(shared_domain) as node:
        yield node


class Client:
    """A script with roslibpy, which writes with `json.dumps`."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection

    def send(self, **operation: Any) -> None:
        self.connection.send(json.dumps(operation))

    def publish(self, topic: str, message: Any, **fields: Any) -> None:
        self.send(op="publish", topic=topic, msg=message, **fields)

    def receive(self) -> dict[str, Any]:
        answer: dict[str, Any] = json.loads(self.connection.recv(PATIENCE))
        return answer

    def error(self, identity: str) -> str:
        """The reason of an error of the default level."""
        answer = self.receive()
        assert (answer["op"], answer["level"], answer["id"]) == ("status", "error", identity)
        return str(answer["msg"])


@contextmanager
def client_of(gateway: RunningGateway) -> Iterator[Client]:
    with open_websocket(f"{gateway.url.replace('http', 'ws')}/rosbridge") as connection:
        client = Client(connection)
        for topic, kind in TOPICS.items():
            client.send(op="advertise", topic=topic, type=kind)
        yield client


def test_floats_arrive_as_they_were(gateway: RunningGateway, observer: Observer) -> None:
    scans, batteries, numbers = (
        observer.record(kind, topic) for kind, topic in zip((LaserScan, BatteryState, Float64), TOPICS, strict=True)
    )
    for topic in TOPICS:  # an earlier message would reach no one
        wait_until(lambda topic=topic: gateway.http.get(f"/graph/topics{topic}").is_success, topic)
    with client_of(gateway) as client:
        client.publish("/readings", {"header": {"frame_id": "NaN"}, "ranges": [1.5, INF, NAN, -INF] * 200})
        scan = scans.wait_for(lambda scan: len(scan.ranges) == 800)
        assert list(map(str, scan.ranges[:4])) == ["1.5", "inf", "nan", "-inf"]
        assert scan.header.frame_id == "NaN"
        client.publish("/measured", {"voltage": 2.5, "current": NAN, "charge": INF, "location": 'Infinity, "NaN"'})
        battery = batteries.wait_for(lambda battery: battery.voltage == 2.5)
        assert (str(battery.current), battery.charge, battery.location) == ("nan", INF, 'Infinity, "NaN"')
        for number in (INF, -INF, NAN, None):
            client.publish("/number", {"data": number})
        numbers.wait_for(lambda number: len(numbers.messages) == 4)
        assert [str(number.data) for number in numbers.messages] == ["inf", "-inf", "nan", "nan"]


def test_what_was_read_can_be_published_again(gateway: RunningGateway, observer: Observer) -> None:
    """What a client gets is JSON for every reader, in arrays too: null, which is NaN when it comes back."""
    scans = observer.record(LaserScan, "/readings")
    with client_of(gateway) as client, client_of(gateway) as reader:
        reader.send(op="subscribe", topic="/readings", type=SCAN)

        def seen() -> str | bytes | None:
            client.publish("/readings", {"ranges": [NAN, 2.0, INF], "range_max": INF})
            with suppress(TimeoutError):
                return reader.connection.recv(0.2)
            return None

        text = wait_until(seen, "a message for the reader")
        read = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))["msg"]
        assert (read["ranges"], read["range_max"]) == ([None, 2.0, None], None)
        client.publish("/readings", read | {"range_min": 7.0})
        scan = scans.wait_for(lambda scan: scan.range_min == 7.0)
        assert list(map(str, scan.ranges)) == ["nan", "2.0", "nan"]


def test_other_fields_refuse_them_and_the_client_is_told(gateway: RunningGateway) -> None:
    with client_of(gateway) as client:
        for message, reason in (
            ({"power_supply_status": NAN}, "power_supply_status: expected uint8"),
            ({"power_supply_status": INF}, "got inf"),
            ({"present": NAN}, "present: expected a boolean, got nan"),
            ({"location": INF}, "location: expected a string, got inf"),
            ({"header": {"stamp": {"sec": NAN}}}, "header.stamp.sec: expected int32"),
            (NAN, "expected an object"),
        ):
            client.publish("/measured", message, id="p")
            assert reason in client.error("p")
        client.publish("/measured", {"location": "x" * 250_000, "voltage": NAN}, id="p")
        long = client.receive()
        assert (long["op"], long["level"]) == ("status", "error")
        assert "longer than 250000 bytes" in long["msg"]
        for field, value in (("throttle_rate", NAN), ("throttle_rate", INF), ("queue_length", NAN)):
            client.send(op="subscribe", topic="/number", id="s", **{field: value})
            assert f"{field}: expected" in client.error("s")
        client.send(op="call_service", service="/rosapi/topics", timeout=NAN, id="c")
        assert "timeout: expected" in client.error("c")
        client.send(op="send_action_goal", action="/fibonacci", args={"order": NAN}, id="g")
        ended = client.receive()
        assert (ended["op"], ended["result"]) == ("action_result", False)
        assert "order: expected int32" in ended["values"]


@pytest.mark.parametrize("topic", TWISTS)
def test_a_velocity_is_finite_at_every_door(gateway: RunningGateway, observer: Observer, topic: str) -> None:
    """Also where null is NaN: what a base does with it is not known."""
    stamped = topic == "/cmd_vel_stamped"
    seen = observer.record(TwistStamped if stamped else Twist, topic)

    def twist(**linear: float | None) -> dict[str, Any]:
        return {"twist": {"linear": linear}} if stamped else {"linear": linear}

    path = "twist.linear.y" if stamped else "linear.y"
    with client_of(gateway) as client:
        client.send(op="advertise", topic=topic, type=TWISTS[topic])
        for number in (NAN, INF, -INF, None):
            client.publish(topic, twist(x=0.1, y=number), id="p")
            assert f"{path}: expected a finite number" in client.error("p")
        refused = gateway.http.post(f"/topics{topic}", json=twist(y=None), params={"type": TWISTS[topic]})
        assert (refused.status_code, refused.json()["errors"][0]["path"]) == (422, path)
        client.publish(topic, twist(x=0.5))
    last = seen.wait_for(lambda message: (message.twist if stamped else message).linear.x == 0.5)
    assert seen.messages == [last]


def test_a_stop_with_such_numbers_is_one(gateway: RunningGateway) -> None:
    with client_of(gateway) as client:
        client.send(op="call_service", service="/dock_gateway/stop", id="s", queued_s=NAN)
        assert client.receive()["result"] is True
    assert gateway.http.get("/stop").json()["latched"] is True
    assert gateway.http.delete("/stop").is_success
