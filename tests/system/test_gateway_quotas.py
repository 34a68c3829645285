"""One viewer takes all that one may have, at each door; those who stop and those who see are served as before."""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from typing import Any

import orjson
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection
from websockets.typing import Subprotocol

from tests.support.access import Site, bearer, stream
from tests.support.clients import open_websocket
from tests.support.gateway import LOW, RunningGateway, running_service_node
from tests.support.installed import needs
from tests.support.waiting import PATIENCE, wait_until

pytestmark = [pytest.mark.ros, needs("rosbridge", "foxglove")]

STRING = "std_msgs/msg/String"
BATTERY = "/battery_status"
FOXGLOVE = [Subprotocol("foxglove.sdk.v1")]
STOP = {"op": "call_service", "id": "stop", "service": "/dock_gateway/stop", "args": {}}


class People:
    """A gateway with logins, and the tokens of those who use it."""

    def __init__(self, gateway: RunningGateway, site: Site) -> None:
        self.gateway = gateway
        self.viewer, self.operator, self.admin = (site.token(role, role) for role in ("viewer", "operator", "admin"))
        wait_until(lambda: self.get(self.admin, "/robots").status_code == 200, "the tokens")

    def get(self, who: str, path: str) -> Any:
        return self.gateway.http.get(path, headers=bearer(who))

    @contextmanager
    def rosbridge(self, who: str) -> Iterator[ClientConnection]:
        url = f"{self.gateway.url.replace('http', 'ws')}/rosbridge"
        with open_websocket(url, additional_headers=bearer(who), max_size=None) as connection:
            yield connection

    @contextmanager
    def foxglove(self, who: str) -> Iterator[tuple[ClientConnection, dict[str, int]]]:
        """A viewer's connection, and the ids of the channels that it is offered as soon as the battery is one."""
        url = f"{self.gateway.url.replace('http', 'ws')}/foxglove"
        with open_websocket(url, subprotocols=FOXGLOVE, additional_headers=bearer(who), max_size=None) as connection:
            channels: dict[str, int] = {}
            while BATTERY not in channels:
                message = orjson.loads(connection.recv(PATIENCE))
                channels |= {each["topic"]: each["id"] for each in message.get("channels", ())}
            yield connection, channels


@pytest.fixture(scope="module")
def people(shared_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[People]:
    site = Site(tmp_path_factory.mktemp("site"))
    settings = {"allow_services": "/robot1/*", "max_subscribers": "80", "max_streams_per_user": "40"}
    with running_service_node(shared_domain), site.gateway(shared_domain, **settings) as gateway:
        people = People(gateway, site)
        body = {"state": LOW, "rate_hz": 10}
        gateway.http.put("/battery/publisher", json=body, headers=bearer(people.admin)).raise_for_status()
        wait_until(lambda: people.get(people.admin, f"/graph/topics{BATTERY}").status_code == 200, "the battery")
        yield people


def subscribe(connection: ClientConnection, topic: str, kind: str = STRING) -> None:
    connection.send(orjson.dumps({"op": "subscribe", "topic": topic, "type": kind}).decode())


def until(connection: ClientConnection, op: str) -> dict[str, Any]:
    """The next message of this kind; binary ones are `data`."""
    while True:
        data = connection.recv(PATIENCE)
        message: dict[str, Any] = {"op": "data"} if isinstance(data, bytes) else orjson.loads(data)
        if message["op"] == op:
            return message


@contextmanager
def unknown_topics(people: People, who: str, number: int, connections: int = 4) -> Iterator[list[str]]:
    """Subscribe to topics that do not exist, in four connections; what the gateway has refused."""
    with ExitStack() as stack:
        refused = []
        for one in range(connections):
            connection = stack.enter_context(people.rosbridge(who))
            connection.send(orjson.dumps({"op": "set_level", "level": "info"}).decode())
            for name in range(number):
                subscribe(connection, f"/nothing{one}_{name}")
                if (message := until(connection, "status"))["level"] == "error":
                    refused.append(message["msg"])
        yield refused


def require_served(people: People, who: str) -> None:
    """Someone reads the battery at every door, and stops at every one."""
    with people.rosbridge(who) as connection:
        subscribe(connection, BATTERY, "sensor_msgs/msg/BatteryState")
        assert until(connection, "publish")["topic"] == BATTERY
        subscribe(connection, "/not_there_yet")
        connection.send(orjson.dumps(STOP).decode())
        assert until(connection, "service_response")["result"] is True
    with people.foxglove(who) as (connection, channels):
        connection.send(
            orjson.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channels[BATTERY]}]}).decode()
        )
        assert until(connection, "data")
    with stream(people.gateway, f"/ws/topics?topic={BATTERY}", who) as connection:
        assert orjson.loads(connection.recv(PATIENCE))["type"] == "topic"
    assert people.gateway.http.post("/stop", headers=bearer(who)).status_code == 200


def test_one_viewer_takes_all_topics_from_no_one(people: People) -> None:
    with unknown_topics(people, people.viewer, 64) as refused:
        assert len(refused) == 4 * 64 - 75
        assert {each.partition(":")[2].strip() for each in refused} == {
            "viewer already has 75 topics subscribed to: that is the share of one user"
        }
        with people.foxglove(people.viewer) as (connection, channels):
            wanted = [{"id": 1, "channelId": channels[BATTERY]}]
            connection.send(orjson.dumps({"op": "subscribe", "subscriptions": wanted}).decode())
            assert "share of one user" in until(connection, "status")["message"]
        for who in (people.operator, people.admin):
            require_served(people, who)
        stopped = people.gateway.http.post("/stop", headers=bearer(people.viewer))  # they stop as ever
        assert stopped.status_code == 200
    wait_until(lambda: _reads_battery(people, people.viewer), "places that were given back")


def _reads_battery(people: People, who: str) -> bool:
    with people.rosbridge(who) as connection:
        subscribe(connection, BATTERY, "sensor_msgs/msg/BatteryState")
        while (message := orjson.loads(connection.recv(PATIENCE)))["op"] not in ("publish", "status"):
            pass
        return bool(message["op"] == "publish")


def test_viewers_together_leave_the_streams_of_those_who_stop(people: People) -> None:
    with ExitStack() as stack:
        for _ in range(40):
            stack.enter_context(stream(people.gateway, "/ws/feedback", people.viewer))
        with pytest.raises(InvalidStatus) as refused:
            stack.enter_context(stream(people.gateway, "/ws/feedback", people.viewer))
        problem = orjson.loads(refused.value.response.body)
        assert (problem["status"], problem["code"]) == (429, "too_many_streams")
        assert problem["detail"] == "viewer already has 40 streams: that is the share of one user"
        for who in (people.operator, people.admin):
            require_served(people, who)


def test_calls_of_one_user_hold_up_no_other(people: People) -> None:
    """They call a service that never answers, as often as they can."""
    people.gateway.http.delete("/stop", headers=bearer(people.admin)).raise_for_status()

    def call(who: str, service: str, timeout: float) -> Any:
        path = f"/services/robot1/{service}?timeout_s={timeout}"
        return people.gateway.http.post(path, json={}, headers=bearer(who)).json()

    with ThreadPoolExecutor(12) as pool:
        waiting = [pool.submit(call, people.operator, "never", 3) for _ in range(12)]
        time.sleep(0.5)
        assert call(people.admin, "never", 0.2)["code"] == "service_timeout"
        assert "code" not in call(people.admin, "echo", 3)
        answers = [each.result() for each in waiting]
    codes = [answer["code"] for answer in answers]
    assert codes.count("service_timeout") == 4
    assert codes.count("too_many_calls") == 8
    details = {answer["detail"] for answer in answers if answer["code"] == "too_many_calls"}
    assert details == {"operator already has 4 calls in progress of /robot1/never: that is the share of one user"}
