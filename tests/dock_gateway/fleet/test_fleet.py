"""All robots at a glance, from parts that are fakes; tests/system has the real ones."""

from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import orjson
import pytest

from dock_gateway.core.event import Event, utc_now
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal, GoalStatus, encode
from dock_gateway.core.grant import Grant, Role
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.hints import Join
from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.registry import DockingServerStates
from dock_gateway.robots.battery import LatestBattery
from dock_gateway.robots.labels import NO_LABEL, RobotLabel
from dock_gateway.settings import Settings
from tests.support.robot_actions import make_robot_actions

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
RELEASED = {"latched": False, "stopped_at": None, "by": None, "robots": [], "persisted": True}


def battery_message(status: int, percentage: float | None = 0.5) -> bytes:
    return orjson.dumps({"voltage": 2.16, "percentage": percentage, "power_supply_status": status})


class Parts:
    """What a fleet is put together from; `outcome` holds the last goal that ended and the last that succeeded."""

    def __init__(self, *names: str) -> None:
        self.fanout = Fanout(queue_limit=10)
        self.robots = {name: self.robot(name) for name in names}
        self.default_namespace = names[0]
        self.goals: list[Goal] = []
        self.outcome: list[Goal | None] = [None, None]
        self.simulator: dict[str, Any] | None = None
        self.looked: list[Any] = []
        self.twice: list[str] = []
        self.labels: dict[str, RobotLabel] = {}

    def robot(self, name: str) -> Any:
        publisher = SimpleNamespace(document=lambda: {"active": False, "rate_hz": None, "published_count": 9})
        return SimpleNamespace(
            namespace=name, battery=LatestBattery(self.fanout, 2.0, name, low_below=0.3), publisher=publisher
        )

    # the registry of robots
    def all(self) -> list[Any]:
        return [self.robots[name] for name in sorted(self.robots)]

    def __contains__(self, name: str) -> bool:
        return name in self.robots

    def owner(self, name: str) -> Any:
        return self.robots.get(name.rpartition("/")[0] or "/")

    # that of actions
    def running(self) -> list[Goal]:
        return [goal for goal in self.goals if not goal.status.terminal]

    def lost(self) -> list[Goal]:
        return [goal for goal in self.goals if goal.status is GoalStatus.LOST]

    def duplicates(self) -> list[str]:
        return self.twice

    def get(self, name: str | None = None) -> Any:
        if name in self.robots:
            return self.robots[name]
        watch = SimpleNamespace(state=ServerState(str(name), "", available=True, answering=True))
        return SimpleNamespace(name=name, watch=watch) if str(name).startswith("/robot1/connect") else None

    def servers_of(self, name: str) -> DockingServerStates:
        return DockingServerStates(*map(self._server, make_robot_actions().docking_pair(name)))

    def _server(self, name: str) -> ServerState:
        action = self.get(name)
        return ServerState(name, "", available=False, answering=False) if action is None else action.watch.state

    # and the others
    def shown(self, _: str) -> dict[str, Any]:
        return RELEASED

    def find(self, _: str) -> Any:
        return None if self.simulator is None else SimpleNamespace(document=lambda: self.simulator)

    def last(self, *_: str) -> Goal | None:
        return self.outcome[0]

    def ran(self, *_: str) -> Goal | None:
        return self.outcome[0]

    def watch(self, *_: str) -> None:
        pass

    def succeeded(self, *_: str) -> Goal | None:
        return self.outcome[1]

    # what looks after them
    def update(
        self, states: list[Any], strays: list[Goal], duplicates: dict[str, list[str]], split: list[Join]
    ) -> None:
        assert split == []
        self.looked.append(([state.name for state in states], [goal.goal_id for goal in strays], duplicates))

    def fleet(self) -> Fleet:
        parts: Any = self
        labels: Any = SimpleNamespace(get=lambda name: self.labels.get(name, NO_LABEL))
        return Fleet(
            Settings(),
            self.fanout,
            robots=parts,
            actions=parts,
            robot_actions=make_robot_actions(),
            hints=DockingHints(Settings(), parts, parts),
            interlock=parts,
            simulators=parts,
            last_goals=parts,
            labels=labels,
            alerts=parts,
        )


def goal(action: str, goal_id: str = "a", status: GoalStatus = GoalStatus.EXECUTING, minute: int = 0) -> Goal:
    goal = Goal(goal_id, action, "pkg/action/Dock", NOON.replace(minute=minute), goal=b"{}", feedback=b"{}")
    goal.verb = "undock" if "disconnect" in action else "dock"
    goal.advance(status, goal.created_at)
    return goal


def document(fleet: Fleet, name: str = "/robot1") -> Any:
    return orjson.loads(encode(fleet.documents(name)[0]))


async def told(subscriber: Subscriber) -> list[dict[str, Any]]:
    events, _ = await subscriber.take(0.01)
    return [orjson.loads(event.data) for event in events]


async def test_a_robot_at_a_glance() -> None:
    parts = Parts("/", "/robot1")
    fleet = parts.fleet()
    parts.goals = [
        goal("/robot1/fibonacci", "old"),
        goal("/robot1/connect_to_charging_dock", "new", minute=1),
        goal("/fibonacci", "elsewhere"),
    ]
    parts.labels["/robot1"] = RobotLabel("Left forklift", ("hall 1",))
    robot = document(fleet)
    assert robot == {
        "name": "/robot1",
        "display_name": "Left forklift",
        "groups": ["hall 1"],
        "default": False,
        "docked": None,
        "simulated": False,
        "charging": None,
        "battery": {
            "state": None,
            "percentage": None,
            "implausible": [],
            "received_at": None,
            "stale": True,
            "stale_after_s": 2.0,
            "low_below": 0.3,
        },
        "battery_topic": "/robot1/battery_status",
        "battery_publisher": {"active": False, "rate_hz": None},
        "stop": RELEASED,
        "dock": {
            "action_name": "/robot1/connect_to_charging_dock",
            "available": True,
            "answering": True,
            "duplicate": False,
            "action_type": "",
        },
        "undock": None,
        "join": None,
        "goals": robot["goals"],
        "last_goal": None,
    }
    assert [running["goal_id"] for running in robot["goals"]] == ["new", "old"]
    assert not {"goal", "feedback", "result"} & robot["goals"][0].keys()
    assert [(robot["name"], robot["default"]) for robot in fleet.documents()] == [("/", True), ("/robot1", False)]
    assert [document(fleet, "/")[field] for field in ("display_name", "groups")] == [None, []]
    await fleet.close()


@pytest.mark.parametrize(
    ("simulated", "supply", "succeeded", "docked"),
    [
        (None, 2, None, None),
        (None, 1, "disconnect_from_charging_dock", True),
        (None, 4, None, True),
        (None, 3, "connect_to_charging_dock", True),
        (None, 1, None, True),
        (None, 2, "disconnect_from_charging_dock", False),
        (False, 1, "connect_to_charging_dock", False),
        (True, 2, "disconnect_from_charging_dock", True),
    ],
)
async def test_whether_a_robot_is_docked(
    simulated: bool | None, supply: int, succeeded: str | None, docked: bool | None
) -> None:
    parts = Parts("/robot1")
    if simulated is not None:
        parts.simulator = {"docked": simulated}
    parts.robots["/robot1"].battery.on_battery(battery_message(supply), 1)
    parts.outcome[1] = goal(f"/robot1/{succeeded}", status=GoalStatus.SUCCEEDED) if succeeded else None
    fleet = parts.fleet()
    assert document(fleet)["docked"] is docked
    assert document(fleet)["simulated"] is (simulated is not None)
    await fleet.close()


async def test_a_lost_docking_goal_is_the_last_one_until_it_returns() -> None:
    parts = Parts("/robot1")
    fleet = parts.fleet()
    parts.outcome[0] = goal("/robot1/connect_to_charging_dock", "old", GoalStatus.ABORTED)
    assert document(fleet)["last_goal"]["goal_id"] == "old"
    parts.goals = [
        goal("/robot1/disconnect_from_charging_dock", "lost", GoalStatus.LOST, minute=1),
        goal("/robot1/fibonacci", "other", GoalStatus.LOST, minute=2),
    ]
    assert document(fleet)["last_goal"]["goal_id"] == "lost"
    parts.goals[0].advance(GoalStatus.EXECUTING, utc_now())
    assert document(fleet)["last_goal"]["goal_id"] == "old"
    await fleet.close()


async def test_the_alarm_sees_all_robots_and_the_goals_of_none() -> None:
    parts = Parts("/robot1", "/robot2")
    fleet = parts.fleet()
    parts.goals = [goal("/fibonacci", "stray", GoalStatus.LOST), goal("/robot1/fibonacci", "own", GoalStatus.LOST)]
    parts.twice = ["/robot1/dock", "/robot1/undock", "/arm/move"]
    fleet.update()
    duplicates = {"/robot1": ["/robot1/dock", "/robot1/undock"], "/arm": ["/arm/move"]}
    assert parts.looked == [(["/robot1", "/robot2"], ["stray"], duplicates)]
    assert [[goal.goal_id for goal in state.lost] for state in fleet.states()] == [["own"], []]
    assert [fleet.state(state.name) for state in fleet.states()] == fleet.states()
    assert fleet.state("/nowhere") is None
    await fleet.close()


DOCK, UNDOCK, OTHER = (f"/robot1/{name}" for name in ("connect_to_charging_dock", "undock", "fibonacci"))


@pytest.mark.parametrize(
    ("lost", "later", "resolved"),
    [
        (DOCK, goal(DOCK, "b", GoalStatus.PENDING, 2), False),
        (DOCK, goal(DOCK, "b", GoalStatus.ACCEPTED, 2), True),
        (DOCK, goal(DOCK, "b", GoalStatus.EXECUTING, 2), True),
        (DOCK, goal(DOCK, "b", GoalStatus.LOST, 2), True),
        (DOCK, goal(DOCK, "b", GoalStatus.EXECUTING, 0), False),
        (DOCK, goal(UNDOCK, "b", GoalStatus.EXECUTING, 2), True),
        (DOCK, goal(OTHER, "b", GoalStatus.EXECUTING, 2), False),
        (OTHER, goal(DOCK, "b", GoalStatus.EXECUTING, 2), True),
        (OTHER, goal(OTHER, "b", GoalStatus.EXECUTING, 2), True),
        ("/fibonacci", goal("/fibonacci", "b", GoalStatus.EXECUTING, 2), True),
        ("/fibonacci", goal(DOCK, "b", GoalStatus.EXECUTING, 2), False),
    ],
)
async def test_a_lost_goal_is_over_when_a_later_one_is_accepted(lost: str, later: Goal, *, resolved: bool) -> None:
    parts = Parts("/robot1")
    fleet = parts.fleet()
    parts.goals = [goal(lost, "a", GoalStatus.LOST, 1), later]
    fleet.update()
    ((_, strays, _),) = parts.looked
    unresolved = [*strays, *(each.goal_id for state in fleet.states() for each in state.lost)]
    assert ("a" not in unresolved) is resolved
    await fleet.close()


@pytest.mark.parametrize(
    ("sent", "ended", "resolved"), [(2, 5, True), (2, 3, False), (0, 5, False), (6, 7, True), (2, 4, False)]
)
async def test_a_lost_goal_is_over_after_one_that_ended_later(sent: int, ended: int, *, resolved: bool) -> None:
    """A goal that the server finished before it was gone says nothing of what came then."""
    parts = Parts("/robot1")
    fleet = parts.fleet()
    lost, other = goal(DOCK, "a", minute=1), goal(DOCK, "b", minute=sent)
    lost.advance(GoalStatus.LOST, NOON.replace(minute=4))
    other.advance(GoalStatus.ABORTED, NOON.replace(minute=ended))
    parts.goals, parts.outcome[0] = [lost], other
    assert [each.goal_id for each in fleet.states()[0].lost] == ([] if resolved else ["a"])
    await fleet.close()


async def test_changes_are_told_once_and_only_while_somebody_asks() -> None:
    parts = Parts("/", "/robot1")
    fleet = parts.fleet()
    published: list[Event] = []
    publish = parts.fanout.publish
    parts.fanout.publish = lambda event: (published.append(event), publish(event))  # type: ignore[func-returns-value]
    fleet.update()
    assert published == []
    asks = parts.fanout.subscribe(EventFilter(frozenset({"goals", "robots"}), robot="/robot1"))
    also = parts.fanout.subscribe(EventFilter(frozenset({"robots"})))
    other = parts.fanout.subscribe(EventFilter())
    fleet.update()
    (event,) = await told(asks)
    assert (event["type"], [robot["name"] for robot in event["robots"]]) == ("robots", ["/", "/robot1"])
    fleet.update()
    assert await told(asks) == []
    parts.robots["/robot1"].battery.on_battery(battery_message(2, None), 1)
    fleet.update()
    (event,) = await told(asks)
    assert [robot["name"] for robot in event["robots"]] == ["/robot1"]
    assert event["robots"][0]["battery"]["state"]["percentage"] is None
    del parts.robots["/robot1"]
    fleet.update()
    (event,) = await told(asks)
    assert (event["robots"], event["gone"]) == ([], ["/robot1"])
    assert len(await told(also)) == 3
    assert await told(other) == []
    assert len([event for event in published if event.topic == "robots"]) == 3
    await fleet.close()


async def test_a_docking_server_elsewhere_is_offered_to_those_who_see_both() -> None:
    parts = Parts("/", "/robot1", "/robot2")
    fleet = parts.fleet()
    parts.robots["/robot2"].battery.on_battery(battery_message(2), 1)
    settings = ['robots."/robot2".dock_action = "/robot1/connect_to_charging_dock"']
    assert document(fleet, "/robot2")["join"]["settings"] == settings
    assert document(fleet, "/")["join"] is None
    (limited,) = fleet.documents("/robot2", Grant(Role.VIEWER, robots=("/robot2",)))
    assert limited["join"] is None
    await fleet.close()
