"""How goals ended, over HTTP: groups, days of a time zone, links to the goals, and what is refused."""

import asyncio
import itertools
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any
from zoneinfo import ZoneInfo

import pytest

from dock_gateway.core.goal import GoalError, GoalStatus
from dock_gateway.extension import extensions
from dock_gateway.extensions.statistics.routes import MAX_DAYS, MAX_ERRORS, describe, divide, read_zone
from dock_gateway.extensions.statistics.tally import Tally
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.settings import Settings
from dock_gateway.storage import GoalFilter, History
from tests.support.history import HistoryInMemory, make_goal
from tests.support.robot_actions import make_known_robots
from tests.support.route_client import RouteClient

BERLIN = ZoneInfo("Europe/Berlin")
DAY = timedelta(days=1)
S = GoalStatus


class Client(RouteClient):
    """`/statistics` and `/goals` of a gateway whose history is in memory, with the robots `/` and `/robot1`."""

    def __init__(self) -> None:
        self.history = HistoryInMemory()

        robots: Any = SimpleNamespace(namespaces=lambda: ["/", "/robot1"])
        actions: Any = SimpleNamespace(goal=lambda _: None)
        self.labels = Labels(self.history.documents("label", RobotLabel), robots.namespaces)
        robot_actions = RobotActions(Settings(), robots, self.labels, self.history)
        goals = Goals(actions, robot_actions, self.history)
        documents = GoalDocuments(self.history)
        documents.fields |= dict.fromkeys(extensions().goal_fields)
        parts = {History: self.history, Goals: goals, GoalDocuments: documents, RobotActions: robot_actions}
        parts[KnownRobots] = make_known_robots(self.history, "/", "/robot1")
        super().__init__(parts)

    def record(self, at: str, status: GoalStatus = S.SUCCEEDED, took: float = 10.0, **more: Any) -> None:
        number = len(asyncio.run(self.history.page(GoalFilter(), limit=1000)))
        goal = make_goal(number, status, **more)
        goal.created_at = datetime.fromisoformat(at)
        goal.finished_at = goal.created_at + timedelta(seconds=took) if status.terminal else None
        self.history.record(goal)
        asyncio.run(self.history.writer.flush())

    def group(self, robot: str, *groups: str) -> None:
        asyncio.run(self.labels.replace(robot, RobotLabel(None, groups)))

    def tag(self, number: int, *tags: str) -> None:
        asyncio.run(self.history.notes.replace_tags(f"goal-{number:04d}", tags))

    def get(self, path: str, status: int = 200) -> Any:
        return self.send("GET", path, status)

    def problem(self, query: str) -> str:
        problem = self.get(f"/statistics?{query}", 422)
        assert problem["code"] == "invalid_field"
        return str(problem["errors"][0]["path"])


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


@pytest.fixture
def busy(client: Client) -> Client:
    blocked, lost = GoalError("blocked", ""), GoalError("action_server_lost", "")
    client.record("2026-11-20T12:00:00Z", took=30.0, action="/robot1/dock", retries=2)
    client.record("2026-11-20T13:00:00Z", S.ABORTED, action="/robot1/dock", retries=1, error=blocked)
    client.record("2026-11-20T23:30:00Z", S.CANCELED, action="/robot1/arm/pick", retries=None)
    client.record("2026-11-22T08:00:00Z", took=10.0, action="/robot2/connect_to_charging_dock", origin="external")
    client.record("2026-11-22T09:00:00Z", S.LOST, action="/robot2/disconnect_from_charging_dock", error=lost)
    client.record("2026-11-22T10:00:00Z", S.EXECUTING, action="/robot2/disconnect_from_charging_dock")
    return client


RANGE = "since=2026-11-20T00:00:00Z&until=2026-11-23T00:00:00Z"


def test_days(busy: Client) -> None:
    found = busy.get(f"/statistics?{RANGE}")
    assert (found["by"], found["time_zone"], found["since"]) == ("day", "UTC", "2026-11-20T00:00:00Z")
    assert [(group["key"], group["ended"]) for group in found["groups"]] == [
        ("2026-11-20", 3),
        ("2026-11-21", 0),
        ("2026-11-22", 2),
    ]
    first, empty, _ = found["groups"]
    assert first["statuses"] == {"succeeded": 1, "canceled": 1, "aborted": 1, "rejected": 0, "lost": 0}
    assert first["success_rate"] == 0.5
    assert first["duration_s"] == {"p10": 30.0, "median": 30.0, "p90": 30.0}
    assert first["mean_retries"] == 1.5
    assert (first["errors"], first["other_errors"]) == ([{"code": "blocked", "count": 1}], 0)
    assert (empty["success_rate"], empty["duration_s"]["median"], empty["mean_retries"]) == (None, None, None)
    assert found["total"]["ended"] == 5
    assert found["total"]["duration_s"] == {"p10": 12.0, "median": 20.0, "p90": 28.0}


def test_the_days_are_those_of_the_time_zone(busy: Client) -> None:
    found = busy.get(f"/statistics?{RANGE}&time_zone=Europe/Berlin")
    assert [(group["key"], group["ended"]) for group in found["groups"]] == [
        ("2026-11-20", 2),
        ("2026-11-21", 1),
        ("2026-11-22", 2),
        ("2026-11-23", 0),
    ]


def test_robots_and_actions(busy: Client) -> None:
    """A robot that has left the graph is one still, by its docking goals."""
    busy.record("2026-11-22T11:00:00Z", action="/robot2/arm/pick")
    busy.record("2026-11-22T12:00:00Z", action="/camera/look")
    robots = busy.get(f"/statistics?{RANGE}&by=robot")["groups"]
    assert [(group["key"], group["ended"]) for group in robots] == [
        ("/", 1),
        ("/robot1", 3),
        ("/robot2", 3),
    ]
    actions = busy.get(f"/statistics?{RANGE}&by=action&robot=/robot2&origin=external")
    assert [(group["key"], group["ended"]) for group in actions["groups"]] == [("/robot2/connect_to_charging_dock", 1)]
    assert actions["total"]["ended"] == 1
    assert busy.get(f"/statistics?{RANGE}&action=/robot1/dock")["total"]["ended"] == 2


def test_a_group_and_tags(busy: Client) -> None:
    """A group has the goals of the robots that are in it now, also of one that has left the graph."""
    busy.record("2026-11-22T11:00:00Z", action="/robot2/arm/pick")
    busy.record("2026-11-22T12:00:00Z", action="/camera/look")
    busy.group("/robot2", "hall 1")
    busy.group("/", "hall 1", "hall 2")
    robots = busy.get(f"/statistics?{RANGE}&by=robot&group=hall%201")["groups"]
    assert [(group["key"], group["ended"]) for group in robots] == [("/", 1), ("/robot2", 3)]
    assert len(busy.get("/goals?group=hall+1")["goals"]) == 5
    assert [goal["action_name"] for goal in busy.get("/goals?group=hall+2")["goals"]] == ["/camera/look"]
    busy.group("/robot2")
    assert busy.get(f"/statistics?{RANGE}&group=hall+1")["total"]["ended"] == 1
    assert busy.get(f"/statistics?{RANGE}&group=Hall+1")["total"]["ended"] == 0
    busy.tag(0, "blocked")
    busy.tag(3, "blocked", "maintenance")
    assert busy.get(f"/statistics?{RANGE}&tag=blocked")["total"]["ended"] == 2
    assert busy.get(f"/statistics?{RANGE}&tag=maintenance&tag=other")["total"]["ended"] == 1


def test_a_robot_with_a_label_has_the_goals_below_it(busy: Client) -> None:
    busy.record("2026-11-22T11:00:00Z", action="/robot7/arm/pick")
    busy.group("/robot7", "hall 1")
    found = busy.get(f"/statistics?{RANGE}&by=robot&group=hall+1")
    assert [(group["key"], group["ended"]) for group in found["groups"]] == [("/robot7", 1)]


def record_weeks(client: Client, robot: str, now: list[float], before: list[float]) -> None:
    for days_ago, durations in ((1, now), (10, before)):
        for took in durations:
            at = datetime.now(UTC) - timedelta(days=days_ago)
            client.record(at.isoformat(), took=took, action=f"{robot}/connect_to_charging_dock")


def test_docking_takes_longer_than_the_week_before(client: Client) -> None:
    """It is only said where there are enough goals, and the medians are apart."""
    week = [20.0, 21.0, 22.0, 22.0, 22.0, 23.0, 24.0, 25.0]
    record_weeks(client, "/slow", [took * 1.5 for took in week], week)
    record_weeks(client, "/few", [took * 1.5 for took in week[:7]], week)
    record_weeks(client, "/same", [took * 1.08 for took in week], week)
    record_weeks(client, "/wide", [15.0] * 4 + [45.0] * 4, week)
    client.record(datetime.now(UTC).isoformat(), action="/slow/arm/pick", took=1.0)
    client.group("/few", "hall 1")
    found = {each["robot"]: each for each in client.get("/statistics/docking-time")["robots"]}
    assert {robot: each["change"] for robot, each in found.items()} == {
        "/slow": 0.5,
        "/few": None,
        "/same": None,
        "/wide": None,
    }
    slow = found["/slow"]
    assert (slow["now"]["median_s"], slow["before"]["median_s"], slow["now"]["succeeded"]) == (33.0, 22.0, 8)
    assert [median for median in slow["days"] if median is not None] == [22.0, 33.0]
    assert len(client.get(f"{slow['now']['goals_path']}&status=succeeded")["goals"]) == 8
    assert [each["robot"] for each in client.get("/statistics/docking-time?group=hall+1")["robots"]] == ["/few"]
    assert client.get("/statistics/docking-time?robot=/robot1")["robots"] == []
    assert client.get("/statistics/docking-time?robot=/none", 404)["code"] == "robot_not_found"


@pytest.mark.parametrize("by", ["day", "robot", "action"])
@pytest.mark.parametrize(
    "more",
    ["", "&robot=/robot1", "&action=/robot1/dock&time_zone=Asia/Tokyo", "&origin=external", "&group=hall+1&tag=a+b"],
)
def test_each_number_leads_to_its_goals(busy: Client, by: str, more: str) -> None:
    busy.group("/robot1", "hall 1")
    busy.tag(1, "a b")
    found = busy.get(f"/statistics?{RANGE}&by={by}{more}")
    for group in (found["total"], *found["groups"]):
        for status, count in group["statuses"].items():
            assert len(busy.get(f"{group['goals_path']}&status={status}")["goals"]) == count
        for error in group["errors"]:
            assert len(busy.get(f"{group['goals_path']}&error={error['code']}")["goals"]) == error["count"]


def test_an_empty_history(client: Client) -> None:
    """By default, the last 30 days; the first and the last are cut off where the range begins and ends."""
    found = client.get("/statistics")
    assert len(found["groups"]) == 31
    assert {group["ended"] for group in (found["total"], *found["groups"])} == {0}
    assert datetime.fromisoformat(found["until"]) - datetime.fromisoformat(found["since"]) == 30 * DAY
    assert found["total"]["success_rate"] is None
    assert client.get("/statistics?by=robot")["groups"] == []


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("since=2026-11-22T00:00:00Z&until=2026-11-21T00:00:00Z", "since"),
        ("since=2026-11-22T00:00:00Z&until=2026-11-22T00:00:00Z", "since"),
        ("since=2300-01-01T00:00:00Z", "since"),
        ("since=yesterday", "since"),
        ("since=2020-01-01T00:00:00Z&until=2026-11-22T00:00:00Z", "since"),
        ("by=dock", "by"),
        ("time_zone=Europe/Atlantis", "time_zone"),
        ("time_zone=Europe", "time_zone"),
        ("time_zone=../../etc/passwd", "time_zone"),
        ("time_zone=", "time_zone"),
        ("time_zone=%00", "time_zone"),
        (f"time_zone={'A' * 65}", "time_zone"),
        ("robot=robot%201", "robot"),
        ("group=", "group"),
        (f"group={'g' * 41}", "group"),
        ("tag=%00", "tag"),
        ("status=lost", "status"),
        ("limit=3", "limit"),
    ],
)
def test_bad_parameters(client: Client, query: str, field: str) -> None:
    assert client.problem(query) == field


def test_a_long_time_can_be_had_by_robot(client: Client) -> None:
    assert client.get("/statistics?by=robot&since=1970-01-01T00:00:00Z")["groups"] == []
    assert client.problem("until=1970-01-01T00:00:00Z") == "since"


def test_goals_by_error_code(busy: Client) -> None:
    assert len(busy.get("/goals?error=blocked&error=action_server_lost")["goals"]) == 2
    assert busy.get("/goals?error=never")["goals"] == []
    for code in ("", "%00", "x" * 201):
        assert busy.get(f"/goals?error={code}", 422)["errors"][0]["path"].startswith("error")


# ---------------------------------------------------------------------- days


def lengths(since: datetime, until: datetime, zone: ZoneInfo) -> list[tuple[str, float]]:
    days = divide(since, until, zone)
    assert next(iter(days.values()))[0] == since
    assert [*days.values()][-1][1] == until
    spans = [*days.values()]
    assert all(left[1] == right[0] for left, right in itertools.pairwise(spans)), "without a gap"
    return [(day, (end - begin) / timedelta(hours=1)) for day, (begin, end) in days.items()]


def test_days_of_daylight_saving() -> None:
    autumn = datetime(2026, 10, 24, 22, tzinfo=UTC)
    assert lengths(autumn, autumn + timedelta(hours=49), BERLIN) == [("2026-10-25", 25.0), ("2026-10-26", 24.0)]
    spring = datetime(2026, 3, 28, 12, tzinfo=UTC)
    assert lengths(spring, spring + 2 * DAY, BERLIN) == [
        ("2026-03-28", 11.0),
        ("2026-03-29", 23.0),
        ("2026-03-30", 14.0),
    ]


def test_a_day_without_midnight() -> None:
    """In Cairo the clock goes from 0:00 to 1:00."""
    since = datetime(2024, 4, 25, 10, tzinfo=UTC)
    assert lengths(since, since + DAY, ZoneInfo("Africa/Cairo")) == [("2024-04-25", 12.0), ("2024-04-26", 12.0)]


def test_a_day_that_was_left_out() -> None:
    """Samoa crossed the date line: there was no 30 December 2011."""
    since = datetime(2011, 12, 29, 20, tzinfo=UTC)
    assert [day for day, _ in lengths(since, since + DAY, ZoneInfo("Pacific/Apia"))] == ["2011-12-29", "2011-12-31"]


def test_there_may_be_so_many_days() -> None:
    since = datetime(2026, 1, 1, tzinfo=UTC)
    assert len(divide(since, since + MAX_DAYS * DAY, read_zone("UTC"))) == MAX_DAYS


def test_rare_error_codes_are_counted_together() -> None:
    errors = Counter({f"code{number}": number for number in range(1, MAX_ERRORS + 3)})
    wanted = GoalFilter(since=datetime(2026, 1, 1, tzinfo=UTC), until=datetime(2026, 1, 2, tzinfo=UTC))
    total = describe(wanted, [("", wanted, Tally(errors=errors))])["total"]
    assert total["errors"][0] == {"code": "code22", "count": 22}
    assert (len(total["errors"]), total["other_errors"]) == (MAX_ERRORS, 3)
