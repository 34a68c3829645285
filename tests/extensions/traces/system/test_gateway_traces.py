"""A goal of a real gateway is one trace at a collector; a collector that is away changes nothing."""

import signal
import time
from collections.abc import Iterator

import pytest

from tests.support.gateway import CHARGING, LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.otlp import Collector, attributes, running_collector
from tests.support.processes import GONE_WITHIN
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

TRACE_ID, PARENT_ID = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"
HEADERS = {"traceparent": f"00-{TRACE_ID}-{PARENT_ID}-01", "X-Request-ID": "job-17"}


@pytest.fixture(autouse=True)
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spans are sent ten times a second, not every five seconds."""
    monkeypatch.setenv("OTEL_BSP_SCHEDULE_DELAY", "100")


@pytest.fixture
def collector(monkeypatch: pytest.MonkeyPatch) -> Iterator[Collector]:
    with running_collector() as collector:
        monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", collector.url)
        yield collector


def send(gateway: RunningGateway) -> str:
    gateway.wait_until_ready()
    gateway.publish(LOW)
    goal_id: str = gateway.http.post("/dock", headers=HEADERS).raise_for_status().json()["goal_id"]
    return goal_id


def dock(gateway: RunningGateway) -> str:
    """Run a goal to its end, with feedback; return its id."""
    with gateway.stream() as stream:
        goal_id = send(gateway)
        stream.until_type("feedback")
        gateway.publish(CHARGING)
        assert stream.until_type("result")["status"] == "succeeded"
    return goal_id


def end(gateway: RunningGateway) -> None:
    """End the gateway, and check that it takes no longer than promised."""
    began = time.monotonic()
    gateway.process.send_signal(signal.SIGTERM)
    assert gateway.process.wait() == -signal.SIGTERM
    assert time.monotonic() - began < GONE_WITHIN


def test_a_goal_is_one_trace(domain: int, collector: Collector) -> None:
    with running_dock_server(domain), running_gateway(domain) as gateway:
        goal_id = dock(gateway)
        wait_until(lambda: collector.named("goal"), "the trace")
    assert set(collector.paths) == {"/v1/traces"}
    assert collector.resources[0]["service.name"] == "dock-gateway"
    (goal,), (submit,) = collector.named("goal"), collector.named("submit")
    assert (goal.trace_id.hex(), goal.parent_span_id.hex()) == (TRACE_ID, PARENT_ID)
    assert (submit.trace_id.hex(), submit.parent_span_id) == (TRACE_ID, goal.span_id)
    expected = {"goal_id": goal_id, "robot": "/", "verb": "dock", "status": "succeeded", "request_id": "job-17"}
    assert attributes(goal).items() >= expected.items()
    assert attributes(goal)["action_name"] == "/connect_to_charging_dock"
    events = [event.name for event in goal.events]
    assert events[0] in {"accepted", "executing"}  # the messages overtake each other
    assert "first feedback" in events
    assert events[-1] == "succeeded"
    moments = [event.time_unix_nano for event in goal.events]
    assert goal.start_time_unix_nano < moments[0]
    assert moments == sorted(moments)
    assert goal.start_time_unix_nano == submit.start_time_unix_nano < submit.end_time_unix_nano < moments[-1]


def test_a_goal_that_is_canceled(domain: int, collector: Collector) -> None:
    with running_dock_server(domain), running_gateway(domain) as gateway:
        goal_id = send(gateway)
        gateway.http.post(f"/dock/{goal_id}/cancel").raise_for_status()
        wait_until(lambda: collector.named("goal"), "the trace")
    (goal,) = collector.named("goal")
    assert "canceled" in [event.name for event in goal.events]
    assert attributes(goal)["status"] == "canceled"


def test_a_goal_that_still_runs_is_sent_when_the_gateway_ends(
    domain: int, collector: Collector, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OTEL_BSP_SCHEDULE_DELAY", "60000")
    with running_dock_server(domain), running_gateway(domain, "env") as gateway:
        send(gateway)
        end(gateway)
    (goal,) = collector.named("goal")
    assert goal.events[-1].name == "gateway closed"


def test_a_collector_that_is_down(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", "http://127.0.0.1:1")
    with running_dock_server(domain), running_gateway(domain, "env") as gateway:
        dock(gateway)
        gateway.process.wait_for("opentelemetry")
        dock(gateway)
        end(gateway)
        assert "Traceback" not in gateway.process.output


def test_a_collector_that_hangs(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    with running_collector(hangs=True) as collector:
        monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", collector.url)
        with running_dock_server(domain), running_gateway(domain, "env") as gateway:
            dock(gateway)
            assert collector.asked.wait(30)
            dock(gateway)
            with gateway.stream(), gateway.stream(path="/ws"):
                send(gateway)
                end(gateway)
            assert "Traceback" not in gateway.process.output
