"""Missions over HTTP: what is queued, listed and changed, and what is refused with which field or code."""

import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.allow_list import AllowList
from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.missions.actions import action_of, covers
from dock_gateway.extensions.missions.book import MAX_MISSIONS, MissionBook
from dock_gateway.extensions.missions.messages import Messages
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.places.place import PlaceBody, PlaceEntry
from dock_gateway.extensions.missions.places.places import MAX_PLACES, Places
from dock_gateway.extensions.missions.step import KINDS
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.graph.publishing import FoundTopic, Publishing
from dock_gateway.graph.service_calls import FoundService, ServiceCalls
from dock_gateway.storage.shared_entries import SharedBook
from tests.extensions.missions.examples import DOCK, queued
from tests.support.history import HistoryInMemory
from tests.support.robot_actions import make_known_robots
from tests.support.route_client import RouteClient

PLAIN = {"steps": [{"dock": {}}, {"wait": {"seconds": 2}}, {"undock": {}}]}


class Services:
    """The service `/reset`, which may be called, and another one that may not; `/later` may be and is not there."""

    listed = AllowList("allow_services", ["/reset", "/later", "/robot2/**"], "the gateway does not call the service")

    async def find(self, name: str, type_name: str | None) -> FoundService:
        if name != "/reset":
            raise NotFound("no service")
        if type_name not in (None, "std_srvs/srv/SetBool"):
            raise InvalidField([FieldError("type", "a type that it has", "got another one", "query")])
        return FoundService(name, "std_srvs/srv/SetBool", ("std_srvs/srv/SetBool",))

    load = staticmethod(ServiceCalls.load)


class Topics:
    """The topic `/light`, which may be published on."""

    def require_allowed(self, name: str) -> None:
        AllowList("allow_publish", ["/light"], "the gateway does not publish on").require(name)

    async def find(self, name: str, _: str | None) -> FoundTopic:
        return FoundTopic(name, "std_msgs/msg/Bool", ("std_msgs/msg/Bool",), latched=False, subscribers=1)

    load = staticmethod(Publishing.load)


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
            messages=Messages(cast("Any", Services()), cast("Any", Topics())),
            places=Places(SharedBook(history.documents("place", PlaceEntry), "place", MAX_PLACES)),
            interlock=cast("Any", self),
        )
        super().__init__({Missions: self.missions, KnownRobots: make_known_robots(history, "/", "/robot2")})

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
        ([{"repeat": {"steps": []}}], "steps.0.repeat.steps"),
        ([{"repeat": {"steps": [{"dock": {}}], "times": 0}}], "steps.0.repeat.times"),
        ([{"repeat": {"steps": [{"dock": {}}]}, "tries": 2}], "steps.0"),
        ([{"repeat": {"steps": [{"dock": {}}, {"notify": {}}]}}], "steps.0.repeat.steps.1.notify.text"),
        ([{"first_that_works": [{"action": {"name": "/fibonacci"}}]}], "steps.0.first_that_works.0.action.goal"),
        ([{"dock": {}, "on_failure": {"go_to": "home"}}], "steps.0.on_failure.go_to"),
        ([{"navigate": {}}], "steps.0.navigate"),
        ([{"navigate": {"pose": {"x": 1}}}], "steps.0.navigate.pose.y"),
        ([{"navigate": {"poses": []}}], "steps.0.navigate.poses"),
        ([{"navigate": {"pose": {"x": 1, "y": 2}, "poses": [{"x": 1, "y": 2}]}}], "steps.0.navigate"),
        ([{"navigate": {"pose": {"x": 1e9, "y": 2}}}], "steps.0.navigate.pose.x"),
        ([{"navigate": {"place": "Shelf A3"}}], "steps.0.navigate.place"),
        ([{"navigate": {"place": "shelf", "pose": {"x": 1, "y": 2}}}], "steps.0.navigate"),
        (
            [{"dock": {}}, {"repeat": {"steps": [{"navigate": {"place": "shelf"}}]}}],
            "steps.1.repeat.steps.0.navigate.place",
        ),
        ([{"call": {"service": "reset"}}], "steps.0.call.service"),
        ([{"call": {"service": "/reset", "request": {"data": 3}}}], "steps.0.call.request.data"),
        ([{"call": {"service": "/reset", "type": "a/srv/B"}}], "steps.0.call.type"),
        ([{"dock": {}}, {"publish": {"topic": "/light", "message": {"date": 3}}}], "steps.1.publish.message.date"),
        ([{"notify": {"text": " "}}], "steps.0.notify.text"),
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
    assert client.ids("?robot=/robot1") == [ids[1]]  # it has left the graph
    assert client.ids("?robot=/robot2") == []
    assert client.send("GET", "/missions?robot=/robot11", 404)["code"] == "robot_not_found"
    assert client.ids("?status=canceled&status=running") == [ids[0]]
    page = client.send("GET", "/missions?limit=2")
    assert client.ids(f"?cursor={page['next_cursor']}") == [ids[0]]
    assert client.send("GET", "/missions?status=lost", 422)["errors"][0]["path"] == "status"


def test_a_mission_that_ends_while_they_are_listed_is_among_them(client: Client) -> None:
    ended = queued(DOCK).but(status=MissionStatus.SUCCEEDED)

    async def end() -> None:
        await client.book.store(32 * "a", ended, lambda _: None)  # not moved to the ended ones yet

    assert client.http.portal is not None
    client.http.portal.call(end)
    assert client.ids("?status=succeeded") == [32 * "a"]
    assert client.ids("?robot=/") == [32 * "a"]


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


def test_a_mission_is_covered_with_all_that_it_uses() -> None:
    client = Client()
    wave: dict[str, Any] = {"action": {"name": "/robot1/wave", "goal": {}}}
    mission = queued(wave, {"dock": {}}, robot="/robot1")
    drive = queued({"navigate": {"pose": {"x": 1, "y": 2}}}, robot="/robot1")
    call = queued({"call": {"service": "/robot1/reset"}}, {"publish": {"topic": "/robot1/light"}}, robot="/robot1")
    foreign = queued({"call": {"service": "/robot2/reset"}}, robot="/robot1")
    publish = queued({"publish": {"topic": "/robot2/light"}}, robot="/robot1")
    both: dict[str, Any] = {"actions": ("/robot1/wave", "/robot1/dock")}
    limits: list[dict[str, Any]] = [
        {},
        {"robots": ("/robot1",)},
        {"robots": ("/robot2",)},
        {"actions": ("/robot1/wave",)},
    ]
    limits += [both, {"actions": ("/robot1/navigate_to_pose",)}]
    for each, covered in (
        (mission, [True, True, False, False, True, False]),
        (drive, [True, True, False, False, False, True]),
        (call, [True, True, False, False, False, False]),
        (foreign, [True, False, False, False, False, False]),
        (publish, [True, False, False, False, False, False]),
    ):
        assert [covers(each, Grant(Role.OPERATOR, **limit), client.actions) for limit in limits] == covered


def test_what_the_settings_do_not_name_is_refused(client: Client) -> None:
    for step in ({"call": {"service": "/other"}}, {"publish": {"topic": "/other"}}):
        refused = client.post({"steps": [step]}, 403)
        assert refused["code"] == "not_allowed"
        assert "/other" in refused["settings"][0]
    assert client.ids() == []
    steps = [
        {"call": {"service": "/later", "request": {"anything": 1}}},  # checked when it is there
        {"call": {"service": "/reset", "request": {"data": True}}},
        {"publish": {"topic": "/light", "message": {"data": True}}},
        {"notify": {"text": "Load me"}},
        {"navigate": {"pose": {"x": 1, "y": -2, "yaw": 1.5}}},
    ]
    mission = client.post({"steps": steps})
    assert [next(kind for kind in KINDS if step[kind] is not None) for step in mission["steps"]] == [*map(_only, steps)]
    assert mission["steps"][4]["navigate"]["pose"] == {"x": 1, "y": -2, "yaw": 1.5, "frame": "map"}


def _only(step: dict[str, Any]) -> str:
    (kind,) = step
    return kind


def test_a_place_has_to_be_there(client: Client) -> None:
    drive = {"steps": [{"navigate": {"place": "shelf"}}]}
    assert client.http.portal is not None
    assert client.post(drive, 422)["errors"][0]["expected"] == "the id of a place; there is none yet"
    for place_id in ("shelf", "hall"):
        client.http.portal.call(client.missions.places.replace, place_id, PlaceBody(x=1, y=2).entry())
    step = client.post(drive)["steps"][0]
    assert (step["navigate"]["place"], step["drives_to"]) == ("shelf", None)
    other = {"steps": [{"navigate": {"place": "desk"}}]}
    assert client.post(other, 422)["errors"][0]["expected"] == "the id of a place: hall, shelf"


def test_where_a_robot_drives() -> None:
    actions = Client().actions
    there = queued({"navigate": {"pose": {"x": 1, "y": 2, "yaw": math.pi, "frame": "hall"}}}).steps[0]
    assert action_of(there, "/robot1", actions) == "/robot1/navigate_to_pose"
    frame, *numbers = _flat((there.request or {})["pose"])
    assert frame == "hall"
    assert numbers == pytest.approx([1, 2, 1, 0])
    place = queued({"navigate": {"place": "shelf"}}).steps[0]
    assert action_of(place, "/robot1", actions) == "/robot1/navigate_to_pose"
    with pytest.raises(ValueError, match="where the place shelf is"):
        place.request  # noqa: B018 - nothing is sent by it
    found = place.model_copy(update={"drives_to": Waypoint(x=1, y=2, frame="hall")})
    assert _flat((found.request or {})["pose"]) == ["hall", 1, 2, 0, 1]
    through = queued({"navigate": {"poses": [{"x": 1, "y": 2}, {"x": 3, "y": 4, "yaw": math.pi / 2}]}}).steps[0]
    assert action_of(through, "/", actions) == "/navigate_through_poses"
    first, last = map(_flat, (through.request or {})["poses"])
    assert first == ["map", 1, 2, 0, 1]
    assert last == ["map", 3, 4, pytest.approx(math.sqrt(0.5)), pytest.approx(math.sqrt(0.5))]


def _flat(stamped: dict[str, Any]) -> list[Any]:
    """Return the frame, x and y of a position, and z and w of an orientation."""
    pose = stamped["pose"]
    return [stamped["header"]["frame_id"], *pose["position"].values(), *pose["orientation"].values()]
