"""Of an event about several robots, a reader whose grant is limited is shown those that it covers."""

from typing import Any

import orjson

from dock_gateway.core.event import Event, fleet_event, overview_event, robot_event, utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.narrowing import by_robot, narrow, narrow_alerts, narrow_robots


def robots(*patterns: str) -> Grant:
    return Grant(Role.OPERATOR, robots=patterns)


NOW = utc_now()


def shown(event: Event, grant: Grant) -> object:
    narrowed = narrow(event, grant)
    return None if narrowed is None else orjson.loads(narrowed.data)


def robots_event(robots: list[dict[str, Any]], gone: list[str]) -> Event:
    return fleet_event("robots", NOW, narrow_robots, robots=robots, gone=gone)


def of_all(kind: str, shown: dict[str, dict[str, Any]]) -> Event:
    return overview_event(kind, shown, NOW, by_robot(kind))


def test_events_about_several_robots_keep_those_of_the_grant() -> None:
    grant = robots("/robot1")
    rows = [{"name": name, "goals": [], "last_goal": None, "join": None} for name in ("/robot1", "/robot2")]
    changed = robots_event(rows, ["/robot1/arm", "/robot3"])
    assert shown(changed, grant) == orjson.loads(robots_event(rows[:1], ["/robot1/arm"]).data)
    alerts = [{"robot": "/robot2"}, {"robot": None}, {"robot": "/robot1"}]
    assert shown(fleet_event("alerts", NOW, narrow_alerts, alerts=alerts), grant) == orjson.loads(
        fleet_event("alerts", NOW, narrow_alerts, alerts=alerts[1:]).data
    )
    scenes = of_all("scenes", {"/robot1": {"x": 1}, "/robot2": {"x": 2}})
    assert shown(scenes, grant) == orjson.loads(of_all("scenes", {"/robot1": {"x": 1}}).data)


def test_events_about_robots_leave_out_the_goals_of_other_actions() -> None:
    grant = Grant(Role.OPERATOR, actions=("/robot1/undock",))
    dock, undock = {"action_name": "/robot1/dock"}, {"action_name": "/robot1/undock"}
    robot = {"name": "/robot1", "goals": [dock, undock], "last_goal": dock, "join": None}
    changed = robots_event([robot], [])
    assert shown(changed, grant) == orjson.loads(
        robots_event([robot | {"goals": [undock], "last_goal": None, "join": None}], []).data
    )
    assert shown(changed, robots("/robot1")) == orjson.loads(changed.data)
    hinted = robots_event([robot | {"join": {"detail": "/docking/dock"}}], [])
    assert shown(hinted, robots("/robot1")) == orjson.loads(changed.data)


def test_events_about_other_robots_alone_are_left_out() -> None:
    grant = robots("/robot1")
    assert narrow(robots_event([{"name": "/robot2"}], ["/robot3"]), grant) is None


def test_other_events_are_the_same_for_all_readers() -> None:
    grant = robots("/robot1")
    battery = robot_event("battery", {}, 1, robot="/robot1")
    assert narrow(battery, grant) is battery


def test_what_comes_with_a_robot_is_limited_to_topics() -> None:
    shown = Event(b"{}", "map", robot="/robot1", source="/map")
    assert narrow(shown, Grant(Role.VIEWER, robots=("/robot1",))) is shown, "a map that all robots share"
    assert narrow(shown, Grant(Role.VIEWER, topics=("/map", "/robot1/*"))) is shown
    assert narrow(shown, Grant(Role.VIEWER, topics=("/robot1/*",))) is None
    event = overview_event(
        "maps", {"/robot1": {"topic": "/map"}, "/robot2": {"topic": "/robot2/map"}}, NOW, by_robot("maps")
    )
    narrowed = narrow(event, Grant(Role.VIEWER, topics=("/robot2/*",)))
    assert narrowed is not None
    assert orjson.loads(narrowed.data)["maps"] == {"/robot2": {"topic": "/robot2/map"}}
