"""Names that are as long as ROS allows are names of robots; longer ones are refused, and cost nothing."""

import time
from collections.abc import Iterator

import pytest
from sensor_msgs.msg import BatteryState

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.installed import needs
from tests.support.observer import Observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

# The longest namespaces whose robot can have a battery topic: 247 characters.
DEEP, WIDE = "/" + "/".join("a" * 115), "/" + "b" * 231
LONG = {
    "deep": "/a" * 2_000,
    "wide": "/" + "a" * 300,
    "huge": "/" + "a" * 50_000,
    "not ASCII": "/%C3%A9" * 100,
    "a line feed": "/a%0A%1B%5B31mb",
}


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with running_gateway(shared_domain, server_wait="0.2") as gateway:
        yield gateway


@pytest.mark.parametrize("name", LONG)
@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/battery?robot={}"),
        ("GET", "/goals?robot={}"),
        ("GET", "/goals?action={}"),
        pytest.param("GET", "/statistics?robot={}", marks=needs("statistics")),
        pytest.param("GET", "/statistics?action={}", marks=needs("statistics")),
        ("GET", "/battery/history?robot={}"),
        ("GET", "/robots?robot={}"),
        ("GET", "/actions{}"),
        ("POST", "/actions{}/goals"),
        ("POST", "/dock?robot={}"),
        ("GET", "/alerts{}"),
    ],
)
def test_a_name_that_is_too_long(gateway: RunningGateway, method: str, path: str, name: str) -> None:
    began = time.monotonic()
    answer = gateway.http.request(method, path.format(LONG[name]))
    assert 400 <= answer.status_code < 500
    assert len(answer.content) < 20_000
    assert time.monotonic() - began < 5.0
    assert "[ERROR]" not in gateway.process.output


@pytest.mark.parametrize("name", LONG)
def test_a_stop_with_a_name_that_is_too_long_stops_all(gateway: RunningGateway, name: str) -> None:
    answer = gateway.http.post(f"/stop?robot={LONG[name]}")
    assert (answer.status_code, answer.json()["stopped"]) == (200, ["/"])
    assert "All robots are stopped" in answer.json()["warning"]["detail"]
    assert len(answer.content) < 20_000
    gateway.http.delete("/stop").raise_for_status()


@pytest.mark.parametrize("name", [DEEP, WIDE])
def test_a_robot_with_the_longest_name(domain: int, observer: Observer, name: str) -> None:
    """What of its topics would be longer is not there; the rest of it works."""
    topic = f"{name}/battery_status"
    with running_gateway(domain) as gateway, observer.publishing(BatteryState(percentage=0.5), topic, heard=False):

        def heard() -> bool:
            return gateway.http.get("/battery", params={"robot": name}).json().get("state") is not None

        wait_until(heard, "the battery")
        assert gateway.http.post("/stop", params={"robot": name}).json()["stop"]["robots"] == [name]
        assert gateway.http.delete("/stop", params={"robot": name}).status_code == 200
        with gateway.stream(f"?robot={name}&include=scene,battery") as stream:
            stream.until_type("battery")
            wait_until(lambda: "cannot be used yet" in gateway.process.output, "the line about its topics")
        assert "[ERROR]" not in gateway.process.output
