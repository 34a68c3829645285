"""A live look at any topic: real gateway, real publishers, real DDS."""

import signal
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import orjson
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from tests.support.gateway import (
    RunningGateway,
    Stream,
    running_gateway,
    running_program,
    running_talker,
)
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

BATTERY, SCAN, TEXTS = "sensor_msgs/msg/BatteryState", "sensor_msgs/msg/LaserScan", "test_msgs/msg/Strings"


@pytest.fixture(scope="module")
def gateway(shared_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningGateway]:
    """A gateway on a machine without the package test_msgs."""
    hidden: Path = tmp_path_factory.mktemp("hidden")
    hidden.joinpath("test_msgs").mkdir()
    hidden.joinpath("test_msgs", "__init__.py").touch()
    with pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        patch.setenv("PYTHONPATH", str(hidden))
        gateway = stack.enter_context(running_gateway(shared_domain, "env", heartbeat_interval="1"))
        patch.undo()
        yield gateway


@pytest.fixture(scope="module")
def talker(shared_domain: int) -> Iterator[None]:
    topics = {
        "battery_status2": (BATTERY, "50"),
        "scan": (SCAN, "10"),
        "latched": ("std_msgs/msg/String", "latched"),
        "lift": (TEXTS, "20"),
    }
    arguments = [part for name, rest in topics.items() for part in ("--topic", ":".join((name, *rest)))]
    with running_talker(shared_domain, "--long", "720", *arguments):
        yield


def wait_for_topic(gateway: RunningGateway, name: str, timeout: float = PATIENCE) -> None:
    """Until somebody publishes, and ROS knows which node it is, which it learns a moment later."""

    def publishers() -> list[str | None]:
        return [found["node"] for found in gateway.http.get(f"/graph/topics{name}").json().get("publishers", ())]

    wait_until(lambda: publishers() and all(publishers()), name, timeout)


def steady_rate(stream: Stream, *, count: int = 4) -> dict[str, Any]:
    """The rate once the window is full."""
    for _ in range(count):
        rate = stream.until_type("rate")
    return rate


@pytest.mark.usefixtures("talker")
def test_who_is_there_what_is_said_and_how_much(gateway: RunningGateway) -> None:
    wait_for_topic(gateway, "/talker0/battery_status2")
    with (
        gateway.echo("/talker0/battery_status2") as stream,
        gateway.echo("talker0/battery_status2", "&max_rate=20") as fast,
    ):
        first = stream.next()
        assert (first["type"], first["message_type"], first["installed"], first["hint"]) == (
            "topic",
            BATTERY,
            True,
            None,
        )
        assert first["topic"]["publishers"][0]["node"] == "/talker0/talker"
        message = stream.until_type("message")
        assert message["message"]["header"]["frame_id"] == ""
        assert (message["topic"], message["abbreviated"]) == ("/talker0/battery_status2", False)
        rate = steady_rate(stream)
        assert 20 < rate["rate_hz"] < 58  # 50 are sent on a machine that has the time
        assert rate["bytes_per_s"] == pytest.approx(rate["rate_hz"] * 76, rel=0.2)
        steady_rate(fast)
        stream.until_type("heartbeat")
        counts = {}
        for name, reader in (("stream", stream), ("fast", fast)):
            rates = [index for index, event in enumerate(reader.seen) if event["type"] == "rate"]
            between = reader.seen[rates[0] : rates[3]]  # 3 s
            counts[name] = sum(event["type"] == "message" for event in between)
        assert 5 <= counts["stream"] <= 17
        assert counts["stream"] < counts["fast"] <= 63

        topic = gateway.http.get("/graph/topics/talker0/battery_status2").json()
        assert [entry["node"] for entry in topic["subscribers"]] == ["/dock_gateway"]
    wait_until(lambda: not gateway.http.get("/graph/topics/talker0/battery_status2").json()["subscribers"], "it leaves")


@pytest.mark.usefixtures("talker")
def test_long_arrays_are_abbreviated(gateway: RunningGateway) -> None:
    wait_for_topic(gateway, "/talker0/scan")
    with gateway.echo("/talker0/scan") as stream:
        message = stream.until_type("message")
        assert message["abbreviated"]
        assert message["lengths"] == {"ranges": 720}
        assert message["message"]["ranges"] == [float(number) for number in range(100)]
        assert stream.until(lambda event: event["type"] == "rate" and event["messages"] > 5)["bytes_per_s"] > 720 * 4


@pytest.mark.usefixtures("talker")
def test_what_was_published_before_is_shown_to_everyone_who_comes(gateway: RunningGateway) -> None:
    wait_for_topic(gateway, "/talker0/latched")
    with gateway.echo("/talker0/latched") as first:
        assert first.until_type("message")["message"]["data"] == ""
        with gateway.echo("/talker0/latched") as second:
            assert second.until_type("message", 5)["message"]["data"] == ""


@pytest.mark.usefixtures("talker")
def test_messages_of_a_missing_package_are_not_heard(gateway: RunningGateway) -> None:
    wait_for_topic(gateway, "/talker0/lift")
    with gateway.echo("/talker0/lift") as stream:
        first = stream.next()
        assert (first["message_type"], first["installed"]) == (TEXTS, False)
        assert "install the Python package of the ROS interfaces test_msgs" in first["hint"]
        stream.until_type("heartbeat")
        assert {event["type"] for event in stream.seen} == {"topic", "heartbeat"}


def test_feedback_of_an_action_is_a_topic_too(gateway: RunningGateway, shared_domain: int) -> None:
    with running_program(shared_domain, "fibonacci_action_server"):
        wait_for_topic(gateway, "/fibonacci/_action/feedback")
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        with gateway.echo("/fibonacci/_action/feedback") as stream:
            assert stream.next()["installed"]
            goal = gateway.http.post("/actions/fibonacci/goals", json={"order": 8}).raise_for_status().json()
            message = stream.until_type("message")["message"]
            assert bytes(message["goal_id"]["uuid"]).hex() == goal["goal_id"].replace("-", "")
            assert message["feedback"]["partial_sequence"][:2] == [0, 1]


def test_a_publisher_that_comes_later_is_heard_and_told_of(gateway: RunningGateway, shared_domain: int) -> None:
    name = "/battery_status"
    with gateway.echo(name) as stream:
        assert stream.next()["topic"]["publishers"][0]["node"] == "/dock_gateway"
        with running_talker(shared_domain, "--topic", f"{name}:{BATTERY}:10"):
            changed = stream.until(
                lambda event: (
                    event["type"] == "topic"
                    and any(entry["node"] == "/talker0/talker" for entry in event["topic"]["publishers"])
                )
            )
            assert changed["message_type"] == BATTERY
            stream.until_type("message")


@pytest.mark.parametrize(
    ("query", "status", "code"),
    [
        ("?topic=/nope", 404, "topic_not_found"),
        ("?topic=/a//b", 404, "topic_not_found"),
        ("", 422, "invalid_field"),
        ("?topic=/rosout&max_rate=0.01", 422, "invalid_field"),
        ("?topic=/rosout&max_rate=21", 422, "invalid_field"),
        ("?topic=/rosout&max_rate=nan", 422, "invalid_field"),
        ("?topic=/rosout&rate=1", 422, "invalid_field"),
    ],
)
def test_refusals(gateway: RunningGateway, query: str, status: int, code: str) -> None:
    with pytest.raises(InvalidStatus) as caught, gateway.stream(query, "/ws/topics"):
        pass
    response = caught.value.response
    assert (response.status_code, orjson.loads(response.body)["code"]) == (status, code)


def test_twenty_topics_at_once_and_no_more(gateway: RunningGateway, shared_domain: int) -> None:
    topics = [f"/many{number}" for number in range(21)]
    arguments = [part for name in topics for part in ("--topic", f"{name}:std_msgs/msg/Bool:5")]
    with running_talker(shared_domain, *arguments), ExitStack() as stack:
        for name in topics:
            wait_for_topic(gateway, name)
        for name in topics[:20]:
            stream = stack.enter_context(gateway.echo(name))
            assert stream.next()["type"] == "topic"
        stream.until_type("message")
        with pytest.raises(InvalidStatus) as caught, gateway.echo(topics[20]):
            pass
        assert caught.value.response.status_code == 429
        assert stack.enter_context(gateway.echo(topics[0])).next()["type"] == "topic"


@pytest.mark.usefixtures("talker")
def test_the_gateway_says_goodbye(shared_domain: int) -> None:
    with running_gateway(shared_domain) as gateway:
        wait_for_topic(gateway, "/talker0/scan")
        with gateway.echo("/talker0/scan") as stream:
            stream.until_type("message")
            gateway.process.send_signal(signal.SIGTERM)
            assert stream.until_type("closing")["reason"] == "shutting_down"
            with pytest.raises(ConnectionClosed) as caught:
                stream.next()
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == 1012
        assert "Traceback" not in gateway.process.output
