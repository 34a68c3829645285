"""Webhooks of real gateways: each alert once, over restarts, with two gateways, and a receiver that comes late."""

import os
import sys
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import Process, free_port
from tests.support.waiting import wait_until
from tests.support.webhooks import Receiver

pytestmark = pytest.mark.ros

EXAMPLE = Path(__file__).parents[4] / "examples/webhook.py"
RAISED, CLEARED = ("alert.raised", "stop_latched"), ("alert.cleared", "stop_latched")
HOOK = {"name": "Control room", "severities": ["critical"], "by": "Ada"}


def put(gateway: RunningGateway, url: str) -> dict[str, Any]:
    stored: dict[str, Any] = gateway.http.put("/webhooks/room", json=HOOK | {"url": url}).raise_for_status().json()
    return stored


def deliveries(gateway: RunningGateway) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = gateway.http.get("/webhooks/room/deliveries").raise_for_status().json()["deliveries"]
    return found


def test_two_gateways_and_a_restart_send_a_stop_once(shared_domain: int, receiver: Receiver, tmp_path: Any) -> None:
    database, stops = f"sqlite:///{tmp_path}/history.db", f"{tmp_path}/stops.json"
    with running_gateway(shared_domain, database_url=database, stop_path=stops) as first:
        put(first, receiver.url)
        with running_gateway(shared_domain, database_url=database) as second:
            wait_until(lambda: second.http.get("/webhooks").json()["webhooks"], "the webhook at the second")
            first.http.post("/stop").raise_for_status()
            wait_until(lambda: receiver.bodies, "the stop")
            wait_until(lambda: second.http.get("/alerts").json()["alerts"], "the stop at the second")
    with running_gateway(shared_domain, database_url=database, stop_path=stops) as again:
        wait_until(lambda: again.http.get("/alerts").json()["alerts"], "the stop, still there")
        wait_until(lambda: again.http.get("/webhooks").json().get("webhooks"), "the webhook, still there")
        again.http.delete("/stop").raise_for_status()
        wait_until(lambda: receiver.seen()[-1] == CLEARED, "the release")
        assert receiver.seen() == [RAISED, CLEARED]
        wait_until(lambda: [each["state"] for each in deliveries(again)] == ["delivered"] * 2, "what came of it")
    (raised, _) = receiver.events()
    assert raised["data"]["robot"] == "/"
    assert raised["text"].startswith("Stopped (/): ")


def test_a_receiver_that_is_down_is_told_later(shared_domain: int, receiver: Receiver) -> None:
    receiver.answers += [503]
    with running_gateway(shared_domain) as gateway:
        put(gateway, receiver.url)
        gateway.http.post("/stop", json={"by": "Ada"}).raise_for_status()
        wait_until(lambda: receiver.bodies, "the first attempt")
        (pending,) = wait_until(lambda: [each for each in deliveries(gateway) if each["attempts"] == 1], "its record")
        assert (pending["state"], pending["status_code"]) == ("pending", 503)
        wait_until(lambda: deliveries(gateway)[0]["state"] == "delivered", "the second attempt")
        assert receiver.bodies == [receiver.bodies[0]] * 2
        assert receiver.events()[0]["text"].startswith("Stopped (/): Ada stopped /")
        gateway.http.delete("/stop").raise_for_status()
        wait_until(lambda: receiver.seen()[-1] == CLEARED, "the release")
    assert "was not delivered: the answer was 503; again at" in gateway.process.output


def test_the_example_of_a_receiver(gateway: RunningGateway) -> None:
    url = f"http://127.0.0.1:{(port := free_port())}"
    stored = gateway.http.put("/webhooks/example", json={"name": "Example", "url": url}).raise_for_status().json()
    environment = {**os.environ, "WEBHOOK_SECRET": stored["secret"], "PORT": str(port)}
    with Process(sys.executable, str(EXAMPLE), env=environment) as receiver:
        receiver.wait_for("Waiting for alerts")
        forged = {"webhook-id": "1", "webhook-timestamp": "1", "webhook-signature": "v1,x"}
        assert httpx2.post(url, json={"text": "forged"}, headers=forged).status_code == 401
        delivery = gateway.http.post("/webhooks/example/test").raise_for_status().json()
        receiver.wait_for(delivery["event"]["text"])
        assert "forged" not in receiver.output
