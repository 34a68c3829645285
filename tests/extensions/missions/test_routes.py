"""Missions over HTTP: what is queued, listed and changed, and what is refused with which field or code."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.errors import Conflict, FieldError, InvalidField
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.missions.actions import covers
from dock_gateway.extensions.missions.book import MAX_MISSIONS, MissionBook
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.missions import Missions
from tests.support.history import HistoryInMemory
from tests.support.route_client import RouteClient

PLAIN = {"steps": [{"dock": {}}, {"wait": {"seconds": 2}}, {"undock": {}}]}


class Client(RouteClient):
    """`/missions` of a gateway with the robots `/` and `/robot1`, which nobody carries out."""

    def __init__(self) -> None:
        history = HistoryInMemory()
        self.stopped = False
        self.actions = actions = cast("Any", SimpleNamespace(docking_name=self.docking_name))
        self.book = MissionBook(
            Fanout(queue_limit=1),
            history.documents("mission", MissionEntry),
            history.documents("ended_mission", MissionEntry),
            lambda mission, grant: covers(mission, grant, actions),
        )
        self.missions = Missions(
            self.book,
            cast("Any", SimpleNamespace(wake=lambda: None)),
            robots=cast("Any", SimpleNamespace(get=lambda name: SimpleNamespace(namespace=name or "/"))),
            actions=cast("Any", SimpleNamespace(get=lambda name: self if name == "/fibonacci" else None)),
            robot_actions=actions,
            interlock=cast("Any", self),
        )
        super().__init__({Missions: self.missions})

    def docking_name(self, verb: str, robot: str) -> str:
        """Stand in for the actions of robots."""
        return f"{robot.rstrip('/')}/{verb}"

    async def read_goal(self, request: dict[str, Any], path: str) -> None:
        """Stand in for the action `/fibonacci`."""
        if "order" not in request:
            raise InvalidField([FieldError(path, "an order", "got none")])

    def require_released(self, robot: str, what: str) -> None:
        """Stand in for the interlock."""
        if self.stopped:
            raise Conflict(f"{robot} was stopped: {what}", code="stop_latched")

    def post(self, body: object = PLAIN, status: int = 201, query: str = "", **headers: str) -> Any:
        return self.send("POST", f"/missions{query}", status, json=body, headers=headers)

    def change(self, mission_id: str, verb: str, status: int = 200) -> Any:
        return self.send("POST", f"/missions/{mission_id}/{verb}", status, template=f"/missions/{{mission_id}}/{verb}")

    def get(self, mission_id: str, status: int = 200) -> Any:
        return self.send("GET", f"/missions/{mission_id}", status, template="/missions/{mission_id}")

    def ids(self, query: str = "") -> list[str]:
        return [mission["mission_id"] for mission in self.send("GET", f"/missions{query}")["missions"]]

    def set(self, mission_id: str, **fields: Any) -> None:
        """Let a mission be in another state."""

        async def store() -> None:
            mission = await self.book.find(mission_id)
            await self.book.change(mission_id, mission, mission.but(**fields))

        assert self.http.portal is not None
        self.http.portal.call(store)


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_a_mission_is_queued_and_canceled(client: Client) -> None:
    answer = client.http.post("/missions", json=PLAIN | {"by": "Ada", "name": " Night "})
    mission = answer.json()
    assert answer.headers["location"] == f"/missions/{mission['mission_id']}"
    assert (mission["robot"], mission["status"], mission["name"], mission["created_by"]) == (
        "/",
        "queued",
        "Night",
        "Ada",
    )
    assert [step["status"] for step in mission["steps"]] == ["waiting", "waiting", "waiting"]
    assert client.get(mission["mission_id"]) == mission
    assert client.change(mission["mission_id"], "cancel")["status"] == "canceled"
    assert client.change(mission["mission_id"], "cancel", 409)["code"] == "mission_ended"
    assert client.get(mission["mission_id"])["status"] == "canceled"
    assert client.get(32 * "0", 404)["code"] == "mission_not_found"


@pytest.mark.parametrize(
    ("steps", "path"),
    [
        ([], "steps"),
        ([{}], "steps.0"),
        ([{"dock": {}, "wait": {"seconds": 1}}], "steps.0"),
        ([{"wait": {}}], "steps.0.wait"),
        ([{"wait": {"seconds": 1, "person": True}}], "steps.0.wait"),
        ([{"wait": {"seconds": -1}}], "steps.0.wait.seconds"),
        ([{"wait": {"until": "tomorrow"}}], "steps.0.wait.until"),
        ([{"wait": {"battery": 80}}], "steps.0.wait.battery"),
        ([{"dock": {}, "tries": 0}], "steps.0.tries"),
        ([{"dock": {}, "timeout_s": "60"}], "steps.0.timeout_s"),
        ([{"dock": {}, "on_failure": "ignore"}], "steps.0.on_failure"),
        ([{"fly": {}}], "steps.0.fly"),
        ([{"action": {"name": "fibonacci"}}], "steps.0.action.name"),
        ([{"dock": {}}, {"action": {"name": "/fibonacci"}}], "steps.1.action.goal"),
        ([{"dock": {}}] * 201, "steps"),
    ],
)
def test_what_is_no_mission(client: Client, steps: list[Any], path: str) -> None:
    assert client.post({"steps": steps}, 422)["errors"][0]["path"] == path
    assert client.ids() == []


def test_a_request_that_is_sent_twice(client: Client) -> None:
    first = client.post(**{"Idempotency-Key": "night"})
    client.set(first["mission_id"], status=MissionStatus.SUCCEEDED)
    again = client.post(**{"Idempotency-Key": "night"})
    assert (again["mission_id"], again["status"]) == (first["mission_id"], "succeeded")
    other = client.post(PLAIN | {"priority": 1}, 409, **{"Idempotency-Key": "night"})
    assert other["code"] == "idempotency_key_reused"
    assert client.post()["mission_id"] != first["mission_id"]


def test_missions_are_listed(client: Client) -> None:
    ids = [client.post(query=query)["mission_id"] for query in ("", "?robot=/robot1", "")]
    client.change(ids[0], "cancel")
    assert client.ids() == ids[::-1]
    assert client.ids("?robot=/robot1") == [ids[1]]
    assert client.ids("?status=canceled&status=running") == [ids[0]]
    page = client.send("GET", "/missions?limit=2")
    assert client.ids(f"?cursor={page['next_cursor']}") == [ids[0]]
    assert client.send("GET", "/missions?status=lost", 422)["errors"][0]["path"] == "status.0"


def test_only_what_is_held_goes_on(client: Client) -> None:
    mission_id = client.post()["mission_id"]
    for verb in ("continue", "skip"):
        assert client.change(mission_id, verb, 409)["code"] == "mission_not_held"
    assert client.change(mission_id, "pause")["held_for"] == "paused"
    assert client.change(mission_id, "pause")["held_for"] == "paused"
    client.stopped = True
    for verb in ("continue", "skip"):
        assert client.change(mission_id, verb, 409)["code"] == "stop_latched"
    client.stopped = False
    assert client.change(mission_id, "continue")["status"] == "queued"


def test_there_are_not_too_many(client: Client) -> None:
    mission = MissionEntry.model_validate_json(
        b'{"robot": "/", "name": null, "priority": 1, "status": "queued", "held_for": null, "step": 0, "error": null,'
        b'"created_by": null, "created_at": "2026-11-30T12:00:00Z", "started_at": null, "finished_at": null,'
        b'"steps": [{"dock": {}}]}'
    )

    async def fill() -> None:
        for number in range(MAX_MISSIONS):
            await client.book.store(f"{number:032x}", mission, lambda _: None)

    assert client.http.portal is not None
    client.http.portal.call(fill)
    refused = client.post(PLAIN, 409)
    assert (refused["code"], refused["limit"]) == ("limit_reached", MAX_MISSIONS)


def test_a_mission_is_covered_with_all_its_actions() -> None:
    client = Client()
    mission = cast(
        "Any",
        SimpleNamespace(
            robot="/robot1",
            steps=[
                SimpleNamespace(action=SimpleNamespace(name="/robot1/wave"), verb=None),
                SimpleNamespace(action=None, verb="dock"),
            ],
        ),
    )
    actions = client.actions
    for limits, covered in (
        ({}, True),
        ({"robots": ("/robot1",)}, True),
        ({"robots": ("/robot2",)}, False),
        ({"actions": ("/robot1/wave",)}, False),
        ({"actions": ("/robot1/wave", "/robot1/dock")}, True),
    ):
        assert covers(mission, Grant(Role.OPERATOR, **limits), actions) is covered
