"""`/ws`: commands and events on one socket, each answered under its id."""

import itertools
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import orjson
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from tests.support.clients import connect
from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, ready_gateway, running_gateway
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros


class Socket:
    """A client of /ws that keeps the events which come between the answers."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.events: list[dict[str, Any]] = []
        self._numbers = itertools.count(1)

    def receive(self, timeout: float = PATIENCE) -> dict[str, Any]:
        message: dict[str, Any] = orjson.loads(self.connection.recv(timeout))
        if "op" not in message:
            self.events.append(message)
        return message

    def ask(self, op: str, **fields: Any) -> dict[str, Any]:
        """Send a command and wait for its answer."""
        identity = str(next(self._numbers))
        self.connection.send(orjson.dumps({"op": op, "id": identity, **fields}).decode())
        while (answer := self.receive()).get("op") is None or answer["id"] != identity:
            pass
        return answer

    def until(self, **expected: Any) -> dict[str, Any]:
        """Read on to an event with these fields, among those that came already, too."""
        deadline = time.monotonic() + PATIENCE
        seen = 0
        while time.monotonic() < deadline:
            for event in self.events[seen:]:
                if expected.items() <= event.items():
                    return event
            seen = len(self.events)
            self.receive()
        raise AssertionError(f"no event {expected}; the last ones were {self.events[-5:]}")


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with ready_gateway(shared_domain) as gateway:
        yield gateway


@contextmanager
def open_socket(gateway: RunningGateway) -> Iterator[Socket]:
    with connect(f"{gateway.url.replace('http', 'ws')}/ws") as connection:
        yield Socket(connection)


@pytest.fixture
def socket(gateway: RunningGateway) -> Iterator[Socket]:
    with open_socket(gateway) as socket:
        yield socket
    gateway.stop_once()
    gateway.http.delete("/battery/publisher")
    for goal in gateway.http.get("/dock").json()["goals"]:
        gateway.wait_for_goal(goal["goal_id"], "succeeded", "canceled", "rejected", "aborted")


def test_the_tutorial_on_one_socket(socket: Socket) -> None:
    assert socket.ask("publish_battery", state=LOW, rate_hz=5)["battery_publisher"]["active"] is True
    ack = socket.ask("subscribe", include=["battery", "cmd_vel"])
    assert (ack["op"], ack["subscription"]) == ("ack", ack["id"])
    socket.until(type="snapshot")
    goal = socket.ask("send_goal", goal={"desired_battery_state": CHARGING})["goal"]
    socket.until(type="feedback", goal_id=goal["goal_id"])
    assert socket.ask("publish_battery", state=CHARGING, rate_hz=5)["battery_publisher"]["active"] is True
    result = socket.until(type="result", goal_id=goal["goal_id"])
    assert result["status"] == "succeeded"
    assert socket.ask("stop_publishing")["battery_publisher"]["active"] is False
    assert socket.ask("unsubscribe", subscription=ack["id"])["op"] == "ack"
    assert socket.ask("unsubscribe", subscription=ack["id"])["error"]["code"] == "invalid_field"


def test_cancel_stop_and_ping(socket: Socket) -> None:
    socket.ask("publish_battery", state=LOW, rate_hz=5)
    goal_id = socket.ask("send_goal")["goal"]["goal_id"]
    assert socket.ask("cancel_goal", goal_id=goal_id)["goal"]["status"] in ("canceling", "canceled")
    socket.ask("subscribe", goal_id=goal_id)

    def refusal() -> dict[str, Any] | None:
        answer = socket.ask("cancel_goal", goal_id=goal_id)
        return answer if answer["op"] != "ack" else None

    again = wait_until(refusal, "the end of the goal")
    assert (again["op"], again["error"]["code"], again["error"]["status"]) == ("error", "goal_terminal", 409)
    second = socket.ask("send_goal", idempotency_key="socket")["goal"]["goal_id"]
    assert socket.ask("send_goal", idempotency_key="socket")["goal"]["goal_id"] == second
    assert socket.ask("send_goal")["error"]["code"] == "dock_busy"
    socket.ask("subscribe", include=["system"])
    stopped = socket.ask("stop", by="Ada")
    assert second in stopped["canceling"] or stopped["unconfirmed"]
    assert (stopped["stop"]["latched"], stopped["stop"]["by"]) == (True, "Ada")
    assert stopped["warning"] is None or stopped["warning"]["code"] == "stop_not_persisted"  # a busy machine's disk
    told = socket.until(type="stop")["stop"]
    assert told | {"persisted": None} == {name: stopped["stop"][name] for name in told} | {"persisted": None}
    assert socket.ask("send_goal")["error"]["code"] == "stop_latched"
    assert socket.ask("release_stop")["stop"]["latched"] is False
    for unclear in ({"robot": 7}, {"robots": "/robot1"}):
        stopped = socket.ask("stop", **unclear)
        assert (stopped["stopped"], stopped["warning"]["code"]) == (["/"], "invalid_field")
        socket.ask("release_stop")
    stopped = socket.ask("stop", by=7, latch=False)
    assert (stopped["stop"]["latched"], stopped["warning"]["errors"][0]["path"]) == (True, "by")
    assert socket.ask("release_stop")["stop"]["latched"] is False
    assert "time" in socket.ask("ping")


def test_each_event_says_to_which_subscription_it_belongs(socket: Socket) -> None:
    first, second = socket.ask("subscribe")["id"], socket.ask("subscribe", feedback=False, include=[])["id"]
    for identity in (first, second):
        socket.until(type="snapshot", subscription=identity)
    socket.ask("publish_battery", state=LOW, rate_hz=5)
    goal_id = socket.ask("send_goal")["goal"]["goal_id"]
    socket.until(type="feedback", goal_id=goal_id, subscription=first)
    socket.ask("unsubscribe", subscription=first)
    socket.events.clear()
    socket.ask("stop", latch=False)
    socket.until(type="status", goal_id=goal_id, status="canceled")
    assert {event["subscription"] for event in socket.events} == {second}


def test_goals_outlive_their_socket(gateway: RunningGateway, socket: Socket) -> None:
    socket.ask("publish_battery", state=LOW, rate_hz=5)
    with open_socket(gateway) as other:
        goal_id = other.ask("send_goal")["goal"]["goal_id"]
    assert gateway.wait_for_goal(goal_id, "executing")["origin"] == "gateway"


def test_a_command_whose_socket_breaks_is_carried_out_once(gateway: RunningGateway, socket: Socket) -> None:
    socket.ask("publish_battery", state=LOW, rate_hz=5)
    before = len(gateway.http.get("/dock").json()["goals"])
    with open_socket(gateway) as other:
        other.connection.send('{"op": "send_goal", "id": "1"}')
        other.connection.close()
    wait_until(lambda: len(gateway.http.get("/dock").json()["goals"]) > before, "the goal")
    time.sleep(0.5)
    goals = gateway.http.get("/dock").json()["goals"]
    assert len(goals) == before + 1
    assert goals[0]["status"] in ("pending", "accepted", "executing")


@pytest.mark.parametrize(
    ("message", "code", "identity"),
    [
        ("dock", "malformed_json", None),
        ("[" * 100_000, "body_too_large", None),
        (b"\0\1", "malformed_json", None),
        ('{"op": "ping"', "malformed_json", None),
        ("[]", "invalid_field", None),
        ("{}", "invalid_field", None),
        ('{"op": 1, "id": "a"}', "invalid_field", None),
        ('{"op": "ping", "id": 1}', "invalid_field", None),
        ('{"op": "dance", "id": "a"}', "invalid_field", "a"),
        ('{"op": "ping", "id": "a", "x": 1}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "goal": []}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "goal": {"desired_battery_state": {"voltage": "x"}}}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "action": "/nothing", "goal": {}}', "action_not_found", "a"),
        ('{"op": "send_goal", "id": "a", "robot": "/robot9"}', "robot_not_found", "a"),
        ('{"op": "send_goal", "id": "a", "action": "connect_to_charging_dock"}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "idempotency_key": ""}', "invalid_field", "a"),
        ('{"op": "cancel_goal", "id": "a"}', "invalid_field", "a"),
        ('{"op": "cancel_goal", "id": "a", "goal_id": "7d9c1c9e-0000-4000-8000-000000000000"}', "goal_not_found", "a"),
        ('{"op": "subscribe"}', "invalid_field", None),
        ('{"op": "subscribe", "id": "a", "include": ["all"]}', "invalid_field", "a"),
        ('{"op": "subscribe", "id": "a", "include": "battery"}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "verb": "fly"}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "verb": "dock", "action": "/fibonacci", "goal": {}}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "verb": "undock", "robot": "/robot9"}', "robot_not_found", "a"),
        ('{"op": "subscribe", "id": "a", "max_rate": 0}', "invalid_field", "a"),
        ('{"op": "subscribe", "id": "a", "after": "yesterday"}', "invalid_field", "a"),
        ('{"op": "publish_battery", "id": "a", "state": {"voltage": 1e300}}', "invalid_field", "a"),
        ('{"op": "subscribe", "id": "a", "robot": "robot 1"}', "invalid_field", "a"),
        ('{"op": "subscribe", "id": "a", "feedback": "some"}', "invalid_field", "a"),
        ('{"op": "send_goal", "id": "a", "robot": "robot 1"}', "invalid_field", "a"),
        ('{"op": "release_stop", "id": "a", "robot": "robot 1"}', "invalid_field", "a"),
        ('{"op": "publish_battery", "id": "a", "state": {}, "robot": "robot 1"}', "invalid_field", "a"),
        ('{"op": "publish_battery", "id": "a", "state": {}, "rate_hz": 1e9}', "invalid_field", "a"),
    ],
)
def test_bad_messages_get_an_error_and_the_socket_goes_on(
    gateway: RunningGateway, message: str | bytes, code: str, identity: str | None
) -> None:
    with open_socket(gateway) as socket:
        socket.connection.send(message)
        answer = socket.receive()
        error = answer["error"]
        assert (answer["op"], error["code"], answer["id"]) == ("error", code, identity)
        assert {each["in"] for each in error.get("errors", ())} <= {"body"}
        assert socket.ask("ping")["op"] == "ack"


def test_two_subscriptions_of_one_name(gateway: RunningGateway) -> None:
    with open_socket(gateway) as socket:
        for code in (None, "subscription_exists"):
            socket.connection.send('{"op": "subscribe", "id": "mine"}')
            while (answer := socket.receive()).get("op") is None:
                pass
            assert answer.get("error", {}).get("code") == code


def test_the_gateway_says_goodbye() -> None:
    with ros_domain() as domain, running_gateway(domain) as gateway, open_socket(gateway) as socket:
        socket.ask("subscribe")
        gateway.process.send_signal(signal.SIGTERM)
        socket.until(type="closing", reason="shutting_down")
        with pytest.raises(ConnectionClosed) as closed:
            socket.receive()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1012
        gateway.process.wait()
        assert "Traceback" not in gateway.process.output
