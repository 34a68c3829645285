"""`/metrics` of a running gateway, read by the library's own parser, and what is written about it."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from prometheus_client import Metric
from prometheus_client.parser import text_string_to_metric_families

from tests.support.gateway import (
    ACTION,
    CHARGING,
    LOW,
    RunningGateway,
    ready_gateway,
)
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

ROOT = Path(__file__).parents[2]
DOCK = {"robot": "/", "action": ACTION, "verb": "dock"}
PAGE = ROOT / "docs" / "metrics.md"
DASHBOARD = ROOT / "observability" / "grafana" / "dashboards" / "dock-gateway.json"
# A metric of ours, of the process or of Python, as one writes it in PromQL.
NAME = re.compile(r"\b(?:dock_gateway|process|python)_[a-z_]+\b")
PARTS = {"counter": ("_total",), "histogram": ("_bucket", "_sum", "_count"), "gauge": ("",)}


def families(gateway: RunningGateway) -> dict[str, Metric]:
    answer = gateway.http.get("/metrics").raise_for_status()
    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    return {family.name: family for family in text_string_to_metric_families(answer.text)}


class Scrape:
    """One answer of `/metrics`."""

    def __init__(self, gateway: RunningGateway) -> None:
        self.families = families(gateway)

    def value(self, name: str, **labels: str) -> float:
        """The value of a series; 0 if there is none yet."""
        samples = (sample for family in self.families.values() for sample in family.samples)
        found = (each.value for each in samples if each.name == f"dock_gateway_{name}" and each.labels == labels)
        return next(found, 0.0)


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    """A gateway on which a goal has run."""
    with ready_gateway(shared_domain) as gateway:
        dock(gateway)
        yield gateway


def dock(gateway: RunningGateway) -> None:
    """Run a goal to its end, with feedback."""
    gateway.publish(LOW)
    with gateway.stream() as stream:
        goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        for _ in range(3):
            stream.until_type("feedback")
        gateway.publish(CHARGING)
        assert stream.until_type("result")["status"] == "succeeded"
        gateway.wait_for_goal(goal_id, "succeeded")
    gateway.http.delete("/battery/publisher")


def test_a_goal_moves_the_counters(gateway: RunningGateway) -> None:
    before = Scrape(gateway)
    dock(gateway)
    wait_until(lambda: Scrape(gateway).value("stream_subscribers") == 0, "the reader has left")
    after = Scrape(gateway)

    def more(name: str, **labels: str) -> float:
        return after.value(name, **labels) - before.value(name, **labels)

    assert more("goals_ended_total", **DOCK, status="succeeded") == 1
    assert more("goal_duration_seconds_count", verb="dock", status="succeeded") == 1
    assert 0 < more("goal_duration_seconds_sum", verb="dock", status="succeeded") < 300
    assert more("events_published_total", kind="feedback") >= 3
    assert more("events_sent_total", kind="feedback") >= 3
    assert more("http_requests_total", method="POST", route="/dock", status="202") == 1
    assert more("http_requests_total", method="GET", route="/ws/feedback", status="101") == 1
    assert more("http_request_duration_seconds_count", method="POST", route="/dock") == 1
    measured = "event_loop_lag_seconds_count"
    wait_until(lambda: Scrape(gateway).value(measured) > before.value(measured), "a measurement, twice a second")


def test_the_state_of_the_gateway(gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    with gateway.stream() as stream:
        goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        stream.until_type("feedback")
        expected_values: tuple[tuple[str, dict[str, str], float], ...] = (
            ("ros_up", {}, 1),
            ("database_reachable", {}, 1),
            ("history_spooled", {}, 0),
            ("dds_participants", {}, 1),
            ("robots", {}, 1),
            ("robots_stopped", {}, 0),
            ("goals_running", {"verb": "dock"}, 1),
            ("goals_missing", {"verb": "dock"}, 0),
            ("action_servers", {"state": "available"}, 1),
            ("stream_subscribers", {}, 1),
            ("websockets", {"route": "/ws/feedback"}, 1),
            ("http_requests_in_progress", {}, 1),  # this one
        )
        for name, labels, expected in expected_values:
            wait_until(lambda n=name, of=labels, to=expected: Scrape(gateway).value(n, **of) == to, name)
        gateway.http.post("/stop").raise_for_status()
        gateway.wait_for_goal(goal_id, "canceled")
    assert Scrape(gateway).value("robots_stopped") == 1
    gateway.http.delete("/stop").raise_for_status()
    assert Scrape(gateway).value("robots_stopped") == 0


def test_alerts(gateway: RunningGateway) -> None:
    gateway.publish({**LOW, "percentage": 0.1})
    wait_until(lambda: Scrape(gateway).value("alerts", severity="warning") >= 1, "the battery is low")
    gateway.publish(CHARGING)
    wait_until(lambda: Scrape(gateway).value("alerts", severity="warning") == 0, "the battery charges")


def test_no_series_holds_what_clients_sent(gateway: RunningGateway) -> None:
    goal_id = gateway.http.get("/dock").json()["goals"][0]["goal_id"]
    gateway.http.get(f"/goals/{goal_id}").raise_for_status()
    gateway.http.get("/nothing/of-the-kind")
    text = gateway.http.get("/metrics").text
    assert goal_id not in text
    assert "of-the-kind" not in text


def exposed(gateway: RunningGateway) -> set[str]:
    """The names that one can use in PromQL."""
    found = families(gateway).values()
    return {f"{family.name}{part}" for family in found for part in PARTS[family.type]}


@pytest.mark.parametrize("path", [DASHBOARD, ROOT / "observability" / "alerts.yml", PAGE])
def test_every_metric_that_is_named_exists(gateway: RunningGateway, path: Path) -> None:
    named = {name for name in NAME.findall(path.read_text()) if not name.endswith("_")}
    assert len(named) > 5
    names = exposed(gateway) | set(families(gateway))
    assert named <= names, f"unknown: {named - names}"


def test_every_metric_is_documented(gateway: RunningGateway) -> None:
    rows = re.findall(r"^\| `(dock_gateway_\w+)` \| (\w+) \|", PAGE.read_text(), re.MULTILINE)
    ours = [family for name, family in families(gateway).items() if name.startswith("dock_gateway_")]
    total = {"counter": "_total"}
    assert sorted(rows) == sorted((f"{family.name}{total.get(family.type, '')}", family.type) for family in ours)
