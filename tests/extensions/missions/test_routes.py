"""Missions over HTTP: what is queued, listed and changed, and what is refused with which field or code."""

import math
from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any, cast

import pytest

from dock_gateway.core.errors import Conflict, NotAllowed
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.share import Share
from dock_gateway.extensions.missions.actions import action_of, covers
from dock_gateway.extensions.missions.book import MAX_MISSIONS, MAX_OF_AGENTS
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.notices import alerts_of_holds
from dock_gateway.extensions.missions.places.place import PlaceBody
from dock_gateway.extensions.missions.routes import router
from dock_gateway.extensions.missions.schema import MissionBody
from dock_gateway.extensions.missions.step import KINDS, StepFields
from dock_gateway.extensions.missions.step_kinds import NavigateStep, Waypoint
from dock_gateway.extensions.missions.tools import TOOLS
from tests.extensions.missions.client import PLAIN, Client
from tests.extensions.missions.examples import DOCK, NOON, queued

TO_SHELF = NavigateStep(pose=Waypoint(x=1, y=2))


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


def test_a_mission_that_has_not_begun_is_edited(client: Client) -> None:
    answer = client.http.post("/missions", json=PLAIN | {"by": "Ada"})
    mission = answer.json()
    mission_id = mission["mission_id"]
    assert answer.headers["etag"] == mission["etag"] == client.get(mission_id)["etag"]
    body = {"name": "Short", "priority": 60, "steps": [{"dock": {}, "tries": 2}]}
    edited = client.put(mission_id, body, **{"If-Match": mission["etag"]})
    assert (edited["name"], edited["priority"], len(edited["steps"])) == ("Short", 60, 1)
    assert [edited[name] for name in ("created_by", "created_at", "order")] == [
        mission[name] for name in ("created_by", "created_at", "order")
    ]
    assert client.get(mission_id) == edited
    refused = client.put(mission_id, PLAIN, 412, **{"If-Match": mission["etag"]})
    assert refused["code"] == "changed_meanwhile"
    assert client.put(mission_id, {"steps": [{"fly": {}}]}, 422)["errors"][0]["path"] == "steps.0.fly"
    assert client.put(mission_id, {"steps": [{"call": {"service": "/other"}}]}, 403)["code"] == "not_allowed"
    client.change(mission_id, "pause")
    assert client.put(mission_id, body)["held_for"] == "paused"
    client.set(mission_id, started_at=NOON)
    assert client.put(mission_id, body, 409)["code"] == "mission_begun"
    client.change(mission_id, "cancel")
    client.set(mission_id, status=MissionStatus.CANCELED)
    assert client.put(mission_id, body, 409)["code"] == "mission_ended"
    assert client.put(32 * "0", body, 404)["code"] == "mission_not_found"


def test_missions_are_moved(client: Client) -> None:
    first, second, third = (client.post()["mission_id"] for _ in range(3))
    urgent = client.post(PLAIN | {"priority": 90})["mission_id"]
    assert client.queue() == [urgent, first, second, third]
    client.move(third, before=first)
    assert client.queue() == [urgent, third, first, second]
    assert client.move(second, after=urgent)["priority"] == 90
    assert client.queue() == [urgent, second, third, first]
    other = client.post(query="?robot=/robot1")["mission_id"]
    assert client.move(third, 409, before=other)["code"] == "other_queue"
    assert client.move(third, 404, before=32 * "0")["code"] == "mission_not_found"
    for wrong in ({}, {"before": first, "after": second}, {"before": "first"}):
        assert client.move(third, 422, **wrong)["code"] == "invalid_field"
    client.set(urgent, status=MissionStatus.RUNNING, started_at=NOON)
    assert client.move(third, 409, before=urgent)["code"] == "mission_begun"
    assert client.move(urgent, 409, before=third)["code"] == "mission_begun"
    client.set(third, status=MissionStatus.FAILED)
    assert client.move(third, 409, before=second)["code"] == "mission_ended"


def test_a_mission_for_a_group(client: Client) -> None:
    body = PLAIN | {"group": "pickers"}
    mission = client.post(body)
    assert (mission["robot"], mission["group"], mission["status"]) == (None, "pickers", "queued")
    assert client.ids() == [mission["mission_id"]]
    assert client.ids("?robot=/robot2") == []
    for wrong, query, path in (
        (body, "?robot=/robot1", "group"),
        (body | {"group": ""}, "", "group"),
        ({"group": "pickers", "steps": [{"action": {"name": "/fibonacci"}}]}, "", "steps.0.action.goal"),
    ):
        assert client.post(wrong, 422, query)["errors"][0]["path"] == path
    assert client.put(mission["mission_id"], {"steps": [{"dock": {}}]})["group"] == "pickers"
    assert client.put(mission["mission_id"], body)["group"] == "pickers"
    assert client.put(mission["mission_id"], PLAIN | {"group": "others"}, 422)["errors"][0]["path"] == "group"
    assert client.change(mission["mission_id"], "continue")["status"] == "queued"
    assert client.change(mission["mission_id"], "pause")["held_for"] == "paused"
    client.stopped = True  # no robot of it in particular
    assert client.change(mission["mission_id"], "continue")["status"] == "queued"
    assert client.change(mission["mission_id"], "cancel")["status"] == "canceled"
    first = client.post(body, **{"Idempotency-Key": "night"})
    client.set(first["mission_id"], robot="/robot1", status=MissionStatus.SUCCEEDED)
    assert client.post(body, **{"Idempotency-Key": "night"})["robot"] == "/robot1"
    assert client.post(PLAIN, 409, "?robot=/robot1", **{"Idempotency-Key": "night"})["code"] == "idempotency_key_reused"


async def test_who_may_queue_and_see_a_mission_for_a_group() -> None:
    client = Client()
    body = MissionBody(group="pickers", steps=[StepFields(dock={}), StepFields(navigate=TO_SHELF)])
    empty = MissionBody(group="nobody", steps=[StepFields(dock={})])
    plain = MissionBody(steps=[StepFields(dock={})])
    both = {"robots": ("/robot1", "/robot2")}
    actions = ("/robot*/dock", "/robot*/navigate_to_pose")
    for limits, allowed in (
        ({}, [True, True, True]),
        ({"share": Share(["/robot1"])}, [True, True, False]),  # another gateway may serve the others of a group
        (both, [True, False, False]),
        (both | {"actions": actions}, [True, False, False]),
        (both | {"actions": ("/robot1/*",)}, [False, False, False]),
        ({"robots": ("/robot1",)}, [False, False, False]),
    ):
        grant = Grant(Role.OPERATOR, **cast("Any", limits))
        for each, may in zip((body, empty, plain), allowed, strict=True):
            entry = each.entry(None if each.group else "/").model_copy(update={"group": each.group})
            if each.group:
                assert covers(entry, grant, client.actions, client.members) is may
            refusal = nullcontext() if may else pytest.raises(NotAllowed)
            with refusal:
                await client.missions.add(f"{len(client.book.all()):032x}", each, None, grant)


def test_missions_without_room_between_them_are_moved(client: Client) -> None:
    ids = [client.post()["mission_id"] for _ in range(4)]
    for at, mission_id in enumerate(ids):
        client.set(mission_id, order=at // 2)
    line = client.queue()
    client.move(line[3], before=line[1])
    assert client.queue() == [line[0], line[3], line[1], line[2]]


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


def test_missions_that_had_not_ended_before_a_time_are_listed(client: Client) -> None:
    early, late, _ = ids = [client.post()["mission_id"] for _ in range(3)]
    for mission_id in (early, late):
        client.change(mission_id, "cancel")
    ended = client.send("GET", f"/missions/{late}")["finished_at"]
    assert client.ids("?since=2026-01-01T00:00:00Z") == ids[::-1]
    assert client.ids(f"?since={ended}") == ids[:0:-1]
    assert client.ids(f"?since={ended}&status=canceled") == [late]
    assert client.send("GET", "/missions?since=now", 422)["errors"][0]["path"] == "since"


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
        grants = [Grant(Role.OPERATOR, **limit) for limit in limits]
        assert [covers(each, grant, client.actions, client.members) for grant in grants] == covered


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


@pytest.mark.parametrize(
    ("robot", "step", "held_for"),
    [
        ("/", {"dock": {}}, "approval"),
        ("/", {"wait": {"seconds": 1}}, "approval"),  # the robot is not another one's meanwhile
        ("/robot1", {"dock": {}}, None),
        ("/robot1", {"action": {"name": "/fibonacci", "goal": {"order": 1}}}, "approval"),
        ("/robot1", {"call": {"service": "/reset"}}, "approval"),
        ("/robot1", {"repeat": {"times": 2, "steps": [{"publish": {"topic": "/light"}}]}}, "approval"),
        ("/robot1", {"wait": {"until": "2026-12-01T06:00:00+01:00"}, "interruptible": False}, None),
    ],
)
def test_a_person_allows_what_an_agent_does_to_a_real_robot(
    client: Client, robot: str, step: dict[str, Any], held_for: str | None
) -> None:
    mission = client.ask(robot, step, battery={"below": 0.2, "charge_to": 0.8})
    assert (mission["held_for"], mission["created_by"]) == (held_for, "planner")
    assert mission["status"] == ("queued" if held_for is None else "held")
    assert client.get(mission["mission_id"]) == mission
    alerts = [*alerts_of_holds(client.book.all().values())]
    assert [alert.kind.value for alert in alerts] == ([] if held_for is None else ["mission_unapproved"])
    if held_for is not None:
        assert client.change(mission["mission_id"], "continue")["status"] == "queued"
        assert [*alerts_of_holds(client.book.all().values())] == []


def test_a_call_of_an_agent_that_is_repeated_makes_one_mission(client: Client) -> None:
    first, again = (client.ask("/", {"dock": {}}, idempotency_key="a") for _ in range(2))
    assert first["mission_id"] == again["mission_id"]
    assert client.ask("/", {"dock": {}})["mission_id"] != first["mission_id"]


def test_agents_leave_room_for_people(client: Client) -> None:
    for _ in range(MAX_OF_AGENTS):
        client.ask("/", {"dock": {}})
    with pytest.raises(Conflict) as refused:
        client.ask("/robot1", {"dock": {}})
    assert refused.value.code == "limit_reached"
    assert client.post()["status"] == "queued"


def test_agents_continue_nothing() -> None:
    needed = {route.name: route.endpoint.operation.role for route in router.routes}  # type: ignore[attr-defined]
    assert {name for name, role in needed.items() if role is Role.OPERATOR} == {
        "continue_mission",
        "move_mission",
        "replace_mission",
        "skip_step",
    }
    assert not {tool.name for tool in TOOLS} & {"continue_mission", "skip_step"}
