"""`/battery/history`: what a plot of the battery's past is made of, by a real gateway from real messages."""

from datetime import datetime, timedelta

import pytest

from tests.support.gateway import CHARGING, LOW, RunningGateway

pytestmark = pytest.mark.ros

FIELDS = ("voltage", "percentage", "current", "temperature")


def test_what_was_published_is_there_at_once(gateway: RunningGateway) -> None:
    with gateway.stream("?include=battery") as stream:
        gateway.publish({**LOW, "current": -1.5}, rate_hz=50.0)
        for _ in range(20):
            low = stream.until_type("battery")
        gateway.publish({**CHARGING, "voltage": 4.5}, rate_hz=50.0)
        high = stream.until(lambda e: e["type"] == "battery" and e["battery"]["state"]["power_supply_status"] == 1)
        gateway.http.delete("/battery/publisher")
    first = next(event for event in stream.seen if event["type"] == "battery")["time"]
    by_default = gateway.http.get("/battery/history").raise_for_status().json()
    assert by_default["robot"] == "/"
    assert by_default["resolution_s"] == pytest.approx(300 / 599)
    assert by_default["power_supply_status"][-1] == 1

    since = (datetime.fromisoformat(first) - timedelta(seconds=1)).isoformat().replace("+00:00", "Z")
    history = gateway.http.get(f"/battery/history?since={since}&points=2000").raise_for_status().json()
    assert first <= history["time"][0] <= history["time"][-1]
    assert sorted(history["time"]) == history["time"]
    for field in FIELDS:
        assert {len(history[field][kind]) for kind in ("mean", "min", "max")} == {len(history["time"])}
    assert (history["power_supply_status"][0], history["power_supply_status"][-1]) == (3, 1)
    assert (min(history["voltage"]["min"]), max(history["voltage"]["max"])) == (2.16, 4.5)
    assert history["current"]["mean"][0] == -1.5
    assert set(history["temperature"]["mean"]) == {None}

    # A span that ends where the second state begins has none of it.
    early = gateway.http.get(f"/battery/history?since={since}&until={high['time']}&points=2").json()
    assert low["time"] <= early["time"][-1] < high["time"]
    assert set(early["power_supply_status"]) == {3}
    assert len(early["time"]) <= 2
    assert {*early["voltage"]["min"], *early["voltage"]["mean"], *early["voltage"]["max"]} == {2.16}
    assert gateway.http.get("/battery/history?robot=/gone").json()["code"] == "robot_not_found"


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("points=1", "points"),
        ("points=2001", "points"),
        ("since=2026-11-21T03:00:00Z&until=2026-11-21T03:00:00Z", "since"),
        ("until=now", "until"),
        ("robot=robot1", "robot"),
        ("step=1", "step"),
    ],
)
def test_what_is_refused(gateway: RunningGateway, query: str, field: str) -> None:
    answer = gateway.http.get(f"/battery/history?{query}")
    assert answer.status_code == 422, answer.text
    assert [error["path"] for error in answer.json()["errors"]] == [field]
