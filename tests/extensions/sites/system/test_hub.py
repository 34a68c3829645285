"""A hub with two real gateways as its sites: what is asked, seen and told through it, whoever is killed meanwhile."""

import signal
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import pytest

from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.hubs import RunningHub, running_hub, site_settings, until_event
from tests.support.installed import needs
from tests.support.nats import NatsServer, nats_server
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

ENDED = ("succeeded", "canceled", "aborted", "rejected")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("hub")


@pytest.fixture(scope="module")
def nats(folder: Path) -> Iterator[NatsServer]:
    with nats_server(folder) as server:
        yield server


@pytest.fixture(scope="module")
def berlin(shared_domain: int, nats: NatsServer, folder: Path) -> Iterator[RunningGateway]:
    with (
        running_dock_server(shared_domain),
        running_gateway(shared_domain, **site_settings(nats.url, folder, "berlin")) as gateway,
    ):
        gateway.wait_until_ready()
        yield gateway


@pytest.fixture(scope="module")
def oslo(nats: NatsServer, folder: Path) -> Iterator[RunningGateway]:
    with ros_domain() as domain, running_gateway(domain, **site_settings(nats.url, folder, "oslo")) as gateway:
        yield gateway


def dock(hub: RunningHub, site: RunningGateway, name: str = "berlin") -> str:
    """Send a goal through the hub, which runs until the battery is charged."""
    site.publish(LOW)
    answer = hub.http.post(f"/sites/{name}/dock", json={"desired_battery_state": CHARGING})
    assert answer.status_code == 202, answer.text
    goal_id: str = answer.json()["goal_id"]
    assert answer.headers["location"] == f"/sites/{name}/goals/{goal_id}"
    return goal_id


def ended_once(hub: RunningHub, goal_id: str) -> bool:
    """Whether the hub has stored the end of a goal, and only once: its status, and then its result."""
    events = hub.get(f"/goals/{goal_id}/history")["events"]
    ends = [event["type"] for event in events if event["type"] == "result" or event["status"] in ENDED]
    return ends == ["status", "result"]


@pytest.fixture
def sites(berlin: RunningGateway, oslo: RunningGateway) -> None:
    """Both sites."""


@pytest.mark.usefixtures("sites")
@needs("audit_log", "statistics")
def test_a_hub_and_its_sites(berlin: RunningGateway, nats: NatsServer, folder: Path) -> None:
    with ExitStack() as stack:
        hub = stack.enter_context(running_hub(nats.url, folder))
        for name in ("berlin", "oslo"):
            hub.wait_for_site(name)
        wait_until(lambda: {robot["name"] for robot in hub.get("/robots")["robots"]} == {"/berlin", "/oslo"}, "robots")
        assert hub.get("/sites/oslo/session")["principal"]["name"] == "hub"
        root = stack.enter_context(hub.stream("/ws/feedback?include=fleet"))
        assert {site["name"] for site in until_event(root, type="snapshot")["sites"]} == {"berlin", "oslo"}
        own = stack.enter_context(hub.stream("/sites/berlin/ws/feedback?include=battery"))
        first = dock(hub, berlin)
        assert until_event(own, type="feedback", goal_id=first)["action_name"] == "/connect_to_charging_dock"
        berlin.publish(CHARGING)
        told = until_event(root, type="result", goal_id=first)
        assert (told["status"], told["action_name"]) == ("succeeded", "/berlin/connect_to_charging_dock")
        assert hub.wait_for_goal(first, "succeeded")["last_event_id"] == told["id"]
        assert hub.get("/goals?robot=/oslo")["goals"] == []
        assert hub.get("/statistics")["total"]["ended"] == 1
        asked = "POST /sites/berlin/dock"
        wait_until(lambda: asked in [each["subject"] for each in hub.get("/audit")["records"]], "the audit log")
        assert hub.http.get("/sites/paris/robots").json()["code"] == "site_not_found"

        second = dock(hub, berlin)
        hub.wait_for_goal(second, "executing", "accepted")
        hub.process.send_signal(signal.SIGKILL)
        hub.process.wait()
        berlin.publish(CHARGING)
        berlin.wait_for_goal(second, "succeeded")
        hub = stack.enter_context(running_hub(nats.url, folder))
        hub.wait_for_goal(second, "succeeded")
        for goal_id in (first, second):
            wait_until(partial(ended_once, hub, goal_id), f"one end of {goal_id}")


def test_a_site_that_is_killed_is_unreachable_and_comes_back_with_all_that_has_ended(
    nats: NatsServer, folder: Path
) -> None:
    with ExitStack() as stack:
        domain = stack.enter_context(ros_domain())
        stack.enter_context(running_dock_server(domain))
        settings = site_settings(nats.url, folder, "turin")
        turin = stack.enter_context(running_gateway(domain, **settings))
        hub = stack.enter_context(running_hub(nats.url, folder))
        turin.wait_until_ready()
        hub.wait_for_site("turin")
        goal_id = dock(hub, turin, "turin")
        hub.wait_for_goal(goal_id, "executing", "accepted")
        turin.process.send_signal(signal.SIGKILL)
        turin.process.wait()
        turin = stack.enter_context(running_gateway(domain, **settings))
        turin.wait_until_ready()
        turin.publish(CHARGING)
        turin.wait_for_goal(goal_id, *ENDED)
        hub.wait_for_site("turin")
        hub.wait_for_goal(goal_id, *ENDED)
        wait_until(partial(ended_once, hub, goal_id), "one end")
