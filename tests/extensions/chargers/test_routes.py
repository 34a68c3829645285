"""Shared docks over HTTP: what is stored and reported, what is refused with which code, and who sees what."""

import asyncio
from collections.abc import Iterator, Mapping
from datetime import timedelta
from types import SimpleNamespace
from typing import Any, cast

import orjson
import pytest
from hypothesis import given, settings

from dock_gateway.core.access import ANYBODY, Principal, PrincipalKind
from dock_gateway.core.dock_adapters import charging_dock
from dock_gateway.core.errors import DockOccupied, GatewayError, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.chargers.alerts import dock_alerts
from dock_gateway.extensions.chargers.board import DockBoard
from dock_gateway.extensions.chargers.dock import DockBody, DockEntry, DockPose, DockRecord, Hold, WaitEntry
from dock_gateway.extensions.chargers.metrics import dock_metrics
from dock_gateway.extensions.chargers.schema import DockReport
from dock_gateway.extensions.chargers.shared_docks import SharedDocks
from dock_gateway.extensions.chargers.watch import DockWatch, Trouble
from dock_gateway.fleet.alert import Alert
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries
from tests.support.entries import SharedStore
from tests.support.history import HistoryInMemory
from tests.support.route_client import RouteClient
from tests.support.versions import STEPS, Resource, Step, require_that_nothing_is_lost

LISTED = ["a", "b"]
ONLY_ROBOT2 = Grant(Role.OPERATOR, robots=("/robot2",))


class Robots:
    """The robots `/robot1` and `/robot2`, whose docking servers know the docks `a` and `b`."""

    names = ("/robot1", "/robot2")
    said: list[str] | None = LISTED

    def owner(self, action_name: str) -> Any:
        return SimpleNamespace(namespace=action_name.rpartition("/")[0])

    def get(self, _: str) -> Any:
        if self.names:
            reading = SimpleNamespace(percentage=0.25)
            return SimpleNamespace(battery=SimpleNamespace(age=0.1, stale_since=None, reading=reading))
        return None

    def states(self) -> list[Any]:
        return [SimpleNamespace(name=name, label=SimpleNamespace(groups=("hall",))) for name in self.names]

    async def document(self, *_: str) -> dict[str, Any]:
        if self.said is None:
            raise Unavailable("it does not answer", code="docks_unavailable")
        pose = {"x": 1.0, "y": 0.0, "theta": 0.0}
        return {"docks": [{"dock_id": name, "frame": None, "pose": pose} for name in self.said]}

    async def measure(self, robot: str, docks: Mapping[str, DockPose]) -> dict[str, float]:
        """Stand in for the transforms: `/robot2` is at x = 5 m on the map, and nobody knows where `/robot1` is."""
        if robot == "/robot1":
            return {}
        return {name: abs(5.0 - pose.x) for name, pose in docks.items() if pose.frame == "map"}


class Client(RouteClient):
    """`/shared-docks` of a gateway."""

    def __init__(self) -> None:
        history, self.robots, self.running = HistoryInMemory(), Robots(), list[Goal]()
        self.fanout = Fanout(queue_limit=100)
        action = SimpleNamespace(name="/dock", family="", default_dock="", adapter=charging_dock.DOCK)
        robots: Any = self.robots
        labels = SimpleNamespace(get=lambda _: SimpleNamespace(groups=("hall",)))
        self.docks = SharedDocks(
            self.book(history),
            self.entries(history, "dock_record", DockRecord),
            self.entries(history, "dock_wait", WaitEntry),
            robots=robots,
            actions=cast("Any", SimpleNamespace(get=lambda _: action, running=lambda: self.running)),
            docks=robots,
            labels=cast("Any", labels),
            distances=robots,
            can_drive=lambda _: True,
        )
        self.watch = DockWatch(self.docks, robots, cast("Any", None), cast("Any", None))
        self.board = DockBoard(self.docks, self.watch, robots, self.fanout)
        super().__init__({DockBoard: self.board})

    @staticmethod
    def book(history: HistoryInMemory) -> Any:
        return SharedBook(history.documents("shared_dock", DockEntry), "shared_dock", 3)

    @staticmethod
    def entries(history: HistoryInMemory, kind: str, model: type) -> Any:
        return SharedEntries(history.documents(kind, model))

    def put(self, dock_id: str = "a", body: object = None, status: int = 201) -> Any:
        path = f"/shared-docks/{dock_id}"
        return self.send("PUT", path, status, template="/shared-docks/{dock_id}", json=body or {})

    def get(self, dock_id: str = "a", status: int = 200) -> Any:
        return self.send("GET", f"/shared-docks/{dock_id}", status, template="/shared-docks/{dock_id}")

    def report(self, body: object, status: int = 200, dock_id: str = "a") -> Any:
        path = f"/shared-docks/{dock_id}/report"
        return self.send("POST", path, status, template="/shared-docks/{dock_id}/report", json=body)

    def alerts(self) -> list[Alert]:
        return [*dock_alerts(self.docks, self.watch.trouble)]

    def call(self, work: Any, *arguments: Any) -> Any:
        assert self.http.portal is not None
        return self.http.portal.call(work, *arguments)

    def admit(self, goal: Goal, sender: Principal | None = ANYBODY) -> str | None:
        """Return the dock that a goal is sent to, if that is another one than it names."""
        fields = self.call(self.docks.admit, sender, goal)
        return None if fields is None else fields["desired_battery_state"]["location"]

    def refused(self, goal: Goal, sender: Principal | None = ANYBODY) -> GatewayError:
        with pytest.raises(GatewayError) as refusal:
            self.admit(goal, sender)
        return refusal.value


def goal(robot: str = "/robot1", dock: str = "", **more: Any) -> Goal:
    """A docking goal that is about to be sent."""
    message = orjson.dumps({"desired_battery_state": {"location": dock}})
    return Goal(f"{robot}{dock}", f"{robot}/dock", "pkg/action/T", utc_now(), goal=message, verb="dock", **more)


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_docks_are_stored_listed_and_removed(client: Client) -> None:
    body = {"robots": {"names": ["/robot1"]}, "pose": {"x": 1.5, "y": 2}, "by": " Ada "}
    dock = client.put(body=body)
    assert (dock["dock_id"], dock["state"], dock["changed_by"]) == ("a", "free", "Ada")
    assert dock["pose"] == {"frame": "map", "x": 1.5, "y": 2.0, "theta": 0.0}
    assert client.put(status=200)["robots"]["all"] is True
    client.put("b.2_C-x")
    assert [each["dock_id"] for each in client.send("GET", "/shared-docks")["shared_docks"]] == ["a", "b.2_C-x"]
    client.put("c")
    assert client.put("d", status=409)["code"] == "limit_reached"
    for _ in range(2):
        assert client.http.delete("/shared-docks/a").status_code == 204
    assert client.get(status=404)["code"] == "shared_dock_not_found"


@pytest.mark.parametrize(
    ("body", "path"),
    [
        ([], ""),
        ({"robots": {}}, "robots"),
        ({"pose": {"x": 1}}, "pose.y"),
        ({"pose": {"x": 1e9, "y": 0}}, "pose.x"),
        ({"dock": "a"}, "dock"),
    ],
)
def test_what_is_no_dock(client: Client, body: object, path: str) -> None:
    problem = client.send("PUT", "/shared-docks/a", 422, template="/shared-docks/{dock_id}", json=body)
    assert [error["path"] for error in problem["errors"]] == [path]


@pytest.mark.parametrize("dock_id", ["-a", "a b", "a" * 61, "%7B%7D"])
def test_what_is_no_name(client: Client, dock_id: str) -> None:
    assert client.put(dock_id, status=422)["errors"][0]["path"] == "dock_id"


@settings(max_examples=20, deadline=None)
@given(STEPS)
def test_of_two_people_who_change_a_dock_none_loses_a_change(steps: list[tuple[Step, int]]) -> None:
    with Client() as client:
        path = "/shared-docks/a"
        resource = Resource(
            client.http, path, lambda number: {"pose": {"x": number, "y": 0}}, lambda dock: int(dock["pose"]["x"])
        )
        require_that_nothing_is_lost(resource, steps)


def test_a_goal_reserves_its_dock_and_another_robot_is_told_who_has_it(client: Client) -> None:
    client.put()
    assert client.admit(goal(dock="a")) is None
    dock = client.get()
    assert (dock["state"], dock["robot"], dock["goal_ids"]) == ("reserved", "/robot1", ["/robot1a"])
    error = client.refused(goal("/robot2", "a"))
    assert isinstance(error, DockOccupied)
    assert (error.code, error.extra["robot"], error.extra["since_at"]) == (
        "dock_occupied",
        "/robot1",
        client.docks.records.all()["a"].hold.since_at,  # type: ignore[union-attr]
    )
    assert (
        client.refused(goal("/robot2", "a"), Principal(None, PrincipalKind.USER, ONLY_ROBOT2, None)).extra["robot"]
        is None
    )
    assert client.get()["waiting"] == [], "nobody waits who has not said so"
    assert client.admit(goal("/robot2", "b")) is None, "it is not shared"
    assert client.get("b", 404)["code"] == "shared_dock_not_found"


@pytest.mark.parametrize("dock", ["", "nearest"])
def test_a_goal_without_a_name_gets_the_first_free_dock(client: Client, dock: str) -> None:
    assert client.admit(goal(dock=dock)) is None, "no dock is shared: it is as it was"
    client.put("a")
    assert client.admit(goal(dock=dock)) == "a"
    assert client.admit(goal("/robot2", dock)) == "b", "a dock of its own is free"
    client.put("b")
    assert client.admit(goal("/robot2", dock)) == "b"
    client.robots.said = None
    assert client.admit(goal(dock=dock)) is None, "a server that does not say what it has decides by itself"


def test_a_robot_whose_place_is_known_gets_the_nearest_free_dock(client: Client) -> None:
    client.robots.said = ["a", "b", "c"]
    for name, x in (("a", 0.0), ("b", 4.5)):
        client.put(name, {"pose": {"x": x, "y": 0.0}})
    assert client.admit(goal("/robot2")) == "b"
    client.report({"occupied_by": "/robot1"}, dock_id="b")
    assert client.admit(goal("/robot2")) == "c", "where its docking server says: x = 1 m, before a, and not shared"
    client.put("c", {"pose": {"x": 0.0, "y": 0.0, "frame": "hall"}})
    assert client.admit(goal("/robot2")) == "a", "the place of c in the robot's map is not known"
    assert client.admit(goal("/robot2")) == "a", "it has it already"
    client.report({"occupied_by": "nobody"}, dock_id="b")
    assert client.admit(goal("/robot2")) == "a", "also if another one is nearer"


def test_what_is_no_goal_to_a_dock_by_name(client: Client) -> None:
    client.put()
    undock = goal(dock="a")
    undock.verb = "undock"
    assert client.admit(undock) is None
    assert client.admit(goal(dock='{"pose": [1, 2, 0]}')) is None
    assert client.get()["state"] == "free"


def test_rules_and_missions_wait_in_a_queue(client: Client) -> None:
    client.put()
    client.admit(goal(dock="a"))
    for _ in range(2):
        client.refused(goal("/robot2", "a", origin="automation"), None)
    (waiting,) = client.get()["waiting"]
    assert (waiting["robot"], waiting["battery"]) == ("/robot2", 0.25)
    client.report({"occupied_by": "nobody"})
    error = client.refused(goal("/robot1", "a"))
    assert error.code == "dock_occupied"
    assert "waits for the dock a, and comes first" in error.detail
    assert client.admit(goal("/robot2", "a", origin="automation"), None) is None
    assert (client.get()["robot"], client.get()["waiting"]) == ("/robot2", [])


def test_a_dock_that_is_out_of_order_or_for_others(client: Client) -> None:
    client.put(body={"robots": {"names": ["/robot2"]}})
    assert client.refused(goal(dock="a")).code == "dock_not_for_robot"
    broken = client.report({"out_of_order": True, "note": "The cable is loose", "by": "Ada"})
    assert (broken["state"], broken["note"]) == ("out_of_order", "The cable is loose")
    error = client.refused(goal("/robot2", "a"))
    assert (error.code, error.detail) == ("dock_out_of_order", "the dock a is out of order: The cable is loose")
    (alert,) = client.alerts()
    assert (alert.kind.value, alert.robot) == ("dock_out_of_order", None)
    assert "a: The cable is loose" in alert.detail
    assert client.report({"out_of_order": False})["state"] == "free"
    assert client.alerts() == []


def test_what_people_say_of_a_dock(client: Client) -> None:
    client.put()
    unknown = client.report({"occupied_by": "unknown", "by": "Ada"})
    assert (unknown["state"], unknown["robot"]) == ("occupied_by_unknown", None)
    assert "Ada says" in unknown["detail"]
    assert client.refused(goal(dock="a")).detail == "a robot without a gateway stands on the dock a"
    assert client.report({"occupied_by": "/robot1/"})["robot"] == "/robot1"
    assert client.report({"occupied_by": "nobody"})["state"] == "free"
    client.running = [goal(dock="a")]
    client.admit(goal(dock="a"))
    busy = client.report({"occupied_by": "nobody"}, 409)
    assert (busy["code"], busy["detail"]) == ("dock_occupied", "a goal drives /robot1 to the dock: cancel it first")
    for body in ({}, {"occupied_by": "some one"}, {"note": "x"}):
        assert {error["path"].partition(".")[0] for error in client.report(body, 422)["errors"]} == {"occupied_by"}
    assert client.report({"occupied_by": "nobody"}, 404, "x")["code"] == "shared_dock_not_found"


def test_a_login_with_limits_sees_and_changes_what_is_about_its_robots(client: Client) -> None:
    client.put("a", {"robots": {"names": ["/robot1", "/robot2"], "groups": ["hall", "yard"]}})
    client.put("b", {"robots": {"names": ["/robot1"]}})
    client.admit(goal(dock="a"))
    subscriber = client.fanout.subscribe(EventFilter(topics=frozenset({"shared_dock"})))
    client.board.publish()
    client.refused(goal("/robot2", "a", origin="automation"), None)
    client.board.publish()
    (event,) = client.call(subscriber.take, 1.0)[0]
    assert event.narrow is not None
    (dock,) = client.call(client.board.documents, ONLY_ROBOT2)
    for shown in (dock, event.narrow(orjson.loads(event.data), ONLY_ROBOT2)["shared_dock"]):
        assert (shown["robot"], shown["goal_ids"]) == (None, [])
        assert shown["detail"] == "Another robot is on its way."
        assert (list(shown["robots"]["names"]), list(shown["robots"]["groups"])) == (["/robot2"], ["hall"])
        assert [each["robot"] for each in shown["waiting"]] == ["/robot2"]
    with pytest.raises(GatewayError) as refused:
        client.call(client.board.report, "a", report(occupied_by="nobody"), ONLY_ROBOT2)
    assert refused.value.code == "not_allowed"
    with pytest.raises(GatewayError) as missing:
        client.call(client.board.report, "b", report(occupied_by="nobody"), ONLY_ROBOT2)
    assert missing.value.code == "shared_dock_not_found"


def report(**said: Any) -> DockReport:
    return DockReport(**said)


def test_changes_are_published_once_also_the_last(client: Client) -> None:
    subscriber = client.fanout.subscribe(EventFilter(topics=frozenset({"shared_dock"})))
    client.board.publish()
    client.put()
    for _ in range(2):
        client.board.publish()
    client.http.delete("/shared-docks/a")
    client.board.publish()
    events = [orjson.loads(event.data) for event in client.call(subscriber.take, 1.0)[0]]
    assert [(each["dock_id"], each["shared_dock"] and each["shared_dock"]["state"]) for each in events] == [
        ("a", "free"),
        ("a", None),
    ]


def test_what_somebody_has_to_act_on(client: Client) -> None:
    client.put()
    client.admit(goal(dock="a"))
    now = utc_now()
    client.watch.trouble = Trouble({"a": now}, {"a": ("/robot2", now)})
    assert client.get()["state"] == "no_contact"
    assert [(alert.kind.value, alert.robot) for alert in client.alerts()] == [("dock_contested", "/robot2")]
    client.watch.trouble = Trouble({"a": now - timedelta(minutes=1)}, {})
    (alert,) = client.alerts()
    assert (alert.kind.value, alert.robot, alert.critical) == ("no_contact_at_dock", "/robot1", True)


def test_a_robot_that_does_not_arrive_while_others_wait(client: Client) -> None:
    client.put()
    client.admit(goal(dock="a"))

    def asked(**ago: float) -> None:
        record = client.docks.records.all()["a"]
        assert record.hold is not None
        hold = record.hold.model_copy(update={"asked_at": utc_now() - timedelta(**ago)})
        client.docks.records.put("a", record.model_copy(update={"hold": hold}))

    asked(minutes=16)
    assert client.alerts() == []  # it keeps nobody from the dock
    client.refused(goal("/robot2", "a", origin="automation"), None)
    (alert,) = client.alerts()
    assert (alert.kind.value, alert.robot, alert.critical) == ("dock_not_reached", "/robot1", False)
    assert "another robot waits" in alert.detail
    asked(minutes=14)
    assert client.alerts() == []


def test_metrics(client: Client) -> None:
    client.put("a")
    client.put("b")
    client.admit(goal(dock="a"))
    client.refused(goal("/robot2", "a", origin="automation"), None)
    docks, waiting = dock_metrics(client.board)
    values = {sample.labels["state"]: sample.value for sample in docks.samples}
    assert (values["reserved"], values["free"], values["occupied"]) == (1, 1, 0)
    assert waiting.samples[0].value == 1


async def test_of_two_gateways_one_gets_the_dock() -> None:
    store = SharedStore[DockRecord]()
    site = Client()
    await site.docks.replace("a", DockBody().entry())
    other = Client()
    other.docks.book = site.docks.book
    site.docks.records, other.docks.records = SharedEntries(store), SharedEntries(store)
    asked = (site.docks.admit(ANYBODY, goal("/robot1", "a")), other.docks.admit(ANYBODY, goal("/robot2", "a")))
    results = await asyncio.gather(*asked, return_exceptions=True)
    assert [type(each) for each in results] in ([type(None), DockOccupied], [DockOccupied, type(None)])
    store.away = True
    with pytest.raises(Unavailable):
        await site.docks.admit(ANYBODY, goal("/robot1", "a"))
    assert isinstance(store.known["a"].hold, Hold)
