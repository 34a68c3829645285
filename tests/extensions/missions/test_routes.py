"""Missions over HTTP: what is queued, listed and changed, and what is refused with which field or code."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.missions.actions import action_of, covers
from dock_gateway.extensions.missions.book import MAX_MISSIONS
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.places.place import PlaceBody
from dock_gateway.extensions.missions.step import KINDS
from dock_gateway.extensions.missions.step_kinds import Waypoint
from tests.extensions.missions.client import PLAIN, Client
from tests.extensions.missions.examples import DOCK, queued


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
        client.http.portal.call(client.places.replace, place_id, PlaceBody(x=1, y=2).entry())
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
