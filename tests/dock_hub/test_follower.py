"""A site is read from where the hub was, whatever is missing in between."""

import itertools
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from dock_gateway.core.event import Event, moment
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.sites.tunnel.failures import SiteFailed
from dock_gateway.storage import History
from dock_hub import follower
from dock_hub.follower import Follower
from dock_hub.mirror import Mirror
from dock_hub.site_view import SiteView
from dock_hub.store import HubStore
from tests.dock_hub.documents import ROBOT
from tests.dock_hub.followed_site import START_NS, FakeSite, snapshot, told
from tests.support.history import open_at
from tests.support.waiting import until

FIRST, SECOND = (f"6a8c2b0a-5c63-4d0e-9c1e-00000000000{number}" for number in (1, 2))


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(follower, "RETRY_FIRST", 0.01)
    monkeypatch.setattr(follower, "RETRY_LAST", 0.01)


def make_goal(goal_id: str, status: GoalStatus, second: int = 0) -> Goal:
    goal = Goal(goal_id, "/robot1/dock", "pkg/action/Dock", moment(START_NS), verb="dock", status=status)
    goal.updated_at = moment(START_NS + second * 10**9)
    goal.finished_at = goal.updated_at if status.terminal else None
    goal.result = b'{"ok":true}' if status is GoalStatus.SUCCEEDED else None
    return goal


class Hub:
    def __init__(self, history: History, site: FakeSite) -> None:
        self.history = history
        self.told: list[Event] = []
        self.store = HubStore(Mirror(history), Fanout(queue_limit=10, keep=self.told.append))
        self.view = SiteView("berlin")
        self.follower = Follower(site, self.view, self.store, history, Mirror(history))  # type: ignore[arg-type]

    def keys(self) -> list[str]:
        return [(event.key or "").removeprefix("berlin:") for event in self.told]


@asynccontextmanager
async def hub(site: FakeSite, folder: Path) -> AsyncIterator[Hub]:
    async with open_at(f"sqlite:///{folder / 'hub.db'}", folder) as history:
        await until(lambda: history.stats().database_reachable)
        opened = Hub(history, site)
        try:
            yield opened
        finally:
            await opened.follower.close()
            await opened.store.close()


async def test_a_site_is_read_on_from_its_last_event_and_ends_are_told_once(tmp_path: Path) -> None:
    running, ended = make_goal(FIRST, GoalStatus.EXECUTING), make_goal(FIRST, GoalStatus.SUCCEEDED, 2)
    events = [told(running, 1), told(make_goal(FIRST, GoalStatus.SUCCEEDED, 2), 2)]
    site = FakeSite(
        [snapshot(), {"type": "heartbeat"}, *events],
        [{"type": "resumed", "count": 1}, events[-1], {"type": "robots", "robots": [], "gone": []}],
    )
    site.goals = {SECOND: make_goal(SECOND, GoalStatus.ABORTED)}
    async with hub(site, tmp_path) as opened:
        await until(lambda: len(site.asked_after) == 2 and not opened.view.robots)
        assert site.asked_after == [None, events[-1]["id"]]
        assert opened.keys()[1:] == [f"z-{FIRST}"]
        goal = await opened.history.get(FIRST)
        assert goal is not None
        assert (goal.status, goal.result, goal.action_name) == (ended.status, ended.result, "/berlin/robot1/dock")
        await until(lambda: not opened.view.behind)
        assert await opened.history.get(SECOND) is not None  # from before, so it is not told


async def test_what_the_site_no_longer_has_as_events_is_read_as_goals(tmp_path: Path) -> None:
    running = make_goal(FIRST, GoalStatus.EXECUTING)
    lost = make_goal(SECOND, GoalStatus.EXECUTING)
    site = FakeSite(
        [snapshot(), told(running, 1), told(lost, 1)],
        [{"type": "gap", "count": 0}, snapshot()],
    )
    site.goals = {FIRST: make_goal(FIRST, GoalStatus.SUCCEEDED, 9)}
    async with hub(site, tmp_path) as opened:
        await until(lambda: len(opened.told) == 5)
        assert set(opened.keys()[2:]) >= {f"s-{FIRST}", f"z-{FIRST}"}
        await until(lambda: not opened.view.behind)
        goals = await opened.history.known([FIRST, SECOND])
        assert {goal.goal_id: goal.status for goal in goals.values()} == {
            FIRST: GoalStatus.SUCCEEDED,
            SECOND: GoalStatus.LOST,  # the site does not know it any more
        }


@pytest.mark.parametrize("nonsense", ["no JSON", {"type": "status", "id": "x"}, {"type": "alerts", "alerts": 5}, [1]])
async def test_nonsense_is_counted_and_the_site_is_tried_again(nonsense: Any, tmp_path: Path) -> None:
    site = FakeSite([snapshot(), nonsense], [snapshot(), {"type": "a newer one"}])
    async with hub(site, tmp_path) as opened:
        await until(lambda: len(site.asked_after) == 2 and not opened.view.behind)
        assert opened.view.malformed == {"malformed": 1}
        assert list(opened.view.robots) == ["/berlin/robot1"]


async def test_why_a_site_cannot_be_followed_is_known_until_it_can(tmp_path: Path) -> None:
    site = FakeSite()
    refusal = SiteFailed("the site berlin does not believe the hub")
    site.refusal = refusal
    async with hub(site, tmp_path) as opened:
        await until(lambda: opened.view.trouble == refusal.detail)
        site.connections, site.refusal = [[snapshot()]], None
        await until(lambda: not opened.view.behind)
        assert opened.view.trouble is None


async def test_what_came_after_an_event_that_cannot_be_read_is_read(tmp_path: Path) -> None:
    running = make_goal(FIRST, GoalStatus.EXECUTING)
    odd = told(make_goal(SECOND, GoalStatus.EXECUTING), 1) | {"status": "of a newer release"}
    unknown = told(make_goal(SECOND, GoalStatus.SUCCEEDED, 1), 2)
    site = FakeSite([snapshot(), odd, unknown, told(running, 3)])
    async with hub(site, tmp_path) as opened:
        await until(lambda: len(opened.keys()) == 1)
        assert opened.view.malformed == {"malformed": 2}
        assert site.asked_after == [None]


async def test_a_site_that_never_stops_talking_leaves_time_for_others(tmp_path: Path) -> None:
    told = itertools.repeat({"type": "robots", "robots": [ROBOT], "gone": []})
    async with hub(FakeSite(itertools.chain([snapshot()], told)), tmp_path) as opened:
        await until(lambda: bool(opened.view.robots))
