"""Follows one site: its events into the store, its robots and alerts into memory, from where the hub was last time."""

import asyncio
import logging
import random
import time
from collections.abc import Iterable
from copy import copy
from typing import Any, Protocol
from urllib.parse import quote

import orjson

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import cancel
from dock_gateway.sites.tunnel.failures import SiteFailed
from dock_gateway.storage import History
from dock_hub.fields import ForeignDocumentError
from dock_hub.goal_documents import Happening, ends_of, finish_goal, read_goal, read_goal_id, read_time, size_of
from dock_hub.mirror import Mirror
from dock_hub.pace import Pace
from dock_hub.reading import Reading, id_before, read_event_id
from dock_hub.renaming import read_alerts, read_approvals, read_names, read_robots
from dock_hub.site_client import Conversation, SiteClient
from dock_hub.site_view import SiteView
from dock_hub.store import SiteReports

log = logging.getLogger(__name__)

# Seconds before the first and the last attempt to follow a site again; each is up to twice as long.
RETRY_FIRST, RETRY_LAST = 0.2, 5.0
# Events of a site that wait for the store; beyond it, the site is not read on.
MAX_WAITING = 500
# Characters of a cursor of a site.
MAX_CURSOR = 200
# Goals whose state is remembered, so that the end of one can be put together; and the bytes of their messages. As many
# may wait for the store.
MAX_GOALS, MAX_GOAL_BYTES = 1000, 8 * 1024 * 1024
# Goals in a page, and pages that are read of a site at most.
PAGE, MAX_PAGES = 200, 50
RUNNING = frozenset(status for status in GoalStatus if not status.final)
# Seconds between two measurements of the round trip.
MEASURE_INTERVAL = 15.0


class Keeper(Protocol):
    """Stores what a site reports."""

    async def keep(self, news: SiteReports) -> None:
        """Store it."""


class Follower:
    """One site that is connected.

    Args:
        client: The API of the site.
        view: Takes robots and alerts.
        keeper: Takes goals and events.
        history: The hub's goals.
        mirror: Knows how far the site was read.
    """

    def __init__(self, client: SiteClient, view: SiteView, keeper: Keeper, history: History, mirror: Mirror) -> None:
        self._client = client
        self._site = client.address.site
        self._view = view
        self._keeper = keeper
        self._history = history
        self._mirror = mirror
        self._goals: dict[str, Goal] = {}
        self._bytes = 0  # of the messages of those goals
        self._news = SiteReports(self._site)
        self._more, self._less = asyncio.Event(), asyncio.Event()
        view.behind = True
        self._task = asyncio.create_task(self._run())

    @property
    def kept_bytes(self) -> int:
        """Bytes of the goals' messages that are in memory, and of those that are to be stored."""
        return self._bytes + self._news.size

    async def close(self) -> None:
        """Follow no longer."""
        await cancel(self._task)
        self._view.behind, self._view.trouble = False, None

    # ------------------------------------------------------------------ the connection

    async def _run(self) -> None:
        pause = RETRY_FIRST
        while True:
            began = time.monotonic()
            self._view.behind = True
            try:
                await self._follow()
            except ForeignDocumentError as error:
                self._complain(error)
            except (GatewayError, TimeoutError) as error:
                self._view.trouble = str(error) or type(error).__name__
                log.info("the site %s cannot be followed: %s", self._site, self._view.trouble)
            except Exception:
                log.exception("while following the site %s", self._site)
            if time.monotonic() - began > RETRY_LAST:
                pause = RETRY_FIRST
            await asyncio.sleep(pause * random.uniform(1, 2))  # noqa: S311 - not a secret
            pause = min(2 * pause, RETRY_LAST)

    async def _follow(self) -> None:
        cursor = self._view.cursor = await self._mirror.cursor(self._site)
        self._news = SiteReports(self._site)
        self._goals.clear()
        self._bytes = 0
        async with self._client.events(cursor) as conversation:
            work = self._read_all(conversation, Reading(cursor)), self._write(), self._measure()
            tasks = [asyncio.create_task(each) for each in work]
            try:
                done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            finally:
                await cancel(*tasks)
            await self._keeper.keep(self._news)  # what was read is kept, and all before it, however the stream ended
            for task in done:
                task.result()

    async def _read_all(self, conversation: Conversation, reading: Reading) -> None:
        pace = Pace()
        async for message in conversation:
            self._view.reported_at = began = time.monotonic()
            self._view.trouble = None
            await self._read(_decode(message), reading)
            await pace.give_way(time.monotonic() - began)  # one site is not all
            await self._make_room()

    async def _make_room(self) -> None:
        """Wait until the store has taken what was read."""
        while len(self._news.happenings) >= MAX_WAITING or self._news.size > MAX_GOAL_BYTES:
            self._less.clear()
            await self._less.wait()

    async def _measure(self) -> None:
        while True:
            self._view.round_trip = await self._client.measure()
            await asyncio.sleep(MEASURE_INTERVAL)

    async def _write(self) -> None:
        while True:
            await self._more.wait()
            self._more.clear()
            news, self._news = self._news, SiteReports(self._site)
            self._less.set()
            if news:
                await self._keeper.keep(news)
                self._view.cursor = news.cursor or self._view.cursor

    # ------------------------------------------------------------------ messages

    async def _read(self, message: dict[str, Any], reading: Reading) -> None:
        match message.get("type"):
            case "status" | "result" as kind:
                await self._read_event(kind, message, reading)
                reading.count_event(self._view)
            case "robots":
                robots, gone = read_robots(self._site, message.get("robots")), message.get("gone")
                self._view.put_robots(robots, read_names(self._site, gone), all_of_them=reading.first_robots)
                reading.first_robots = False
            case "alerts":
                self._view.put_alerts(read_alerts(self._site, message.get("alerts")))
            case "approvals":
                self._view.put_approvals(read_approvals(self._site, message.get("approvals")))
            case "snapshot":
                await self._read_snapshot(message, reading)
            case "resumed":
                reading.begin(message, self._view)
            case "gap":
                reading.gap = True
            case "closing":
                log.info("the site %s ends the stream: %s", self._site, message.get("reason"))

    async def _read_event(self, kind: str, message: dict[str, Any], reading: Reading) -> None:
        identity, at = read_event_id(message.get("id")), read_time(message.get("time"))
        try:
            if kind == "status":
                goal = read_goal(self._site, message)
            else:
                goal = await self._find(read_goal_id(message.get("goal_id")))
                finish_goal(goal, message)
        except ForeignDocumentError as error:  # it stays so: what came after it is read nevertheless
            self._complain(error)
        else:
            self._note(goal)
            self._news.happenings.append(Happening("status" if kind == "status" else "result", copy(goal), at))
        reading.newest = max(identity, reading.newest)
        if not reading.gap:  # else what is missing has to be read first
            self._news.cursor = reading.newest
        self._more.set()

    def _complain(self, error: ForeignDocumentError) -> None:
        self._view.malformed["malformed"] += 1
        log.warning("the site %s sends what cannot be read: %s", self._site, error)

    def _note(self, goal: Goal) -> None:
        if (before := self._goals.pop(goal.goal_id, None)) is not None:
            self._bytes -= size_of(before)
        self._goals[goal.goal_id] = self._news.goals[goal.goal_id] = goal
        size = size_of(goal)
        self._news.size += size
        self._bytes += size
        while len(self._goals) > MAX_GOALS or self._bytes > MAX_GOAL_BYTES:
            self._bytes -= size_of(self._goals.pop(next(iter(self._goals))))

    async def _find(self, goal_id: str) -> Goal:
        """Return a goal that has ended: as reported before, as stored, or as the site has it."""
        if (known := self._goals.get(goal_id) or await self._stored(goal_id)) is not None:
            return copy(known)
        goal = await self._ask(goal_id)
        if goal is None:
            raise ForeignDocumentError(f"the goal {goal_id} has ended, and the site does not know it")
        return goal

    async def _stored(self, goal_id: str) -> Goal | None:
        goal = await self._history.get(goal_id)
        return goal if goal is not None and self._is_ours(goal) else None

    def _is_ours(self, goal: Goal) -> bool:
        return goal.action_name.startswith(f"/{self._site}/")

    async def _ask(self, goal_id: str) -> Goal | None:
        status, document = await self._client.get(f"/goals/{goal_id}")
        if status == 404:
            return None
        if status != 200:
            raise SiteFailed(f"GET /goals/{goal_id} is answered with {status}")
        return read_goal(self._site, document)

    # ------------------------------------------------------------------ what was missed

    async def _read_snapshot(self, message: dict[str, Any], reading: Reading) -> None:
        self._view.put_robots(read_robots(self._site, message.get("robots")), all_of_them=True)
        self._view.put_alerts(read_alerts(self._site, message.get("alerts")))
        self._view.put_approvals(read_approvals(self._site, message.get("approvals")))
        reading.first_robots = False
        documents = message.get("goals")
        if not isinstance(documents, list):
            raise ForeignDocumentError("a snapshot without goals")
        ids = [each.get("last_event_id") for each in documents if isinstance(each, dict)]
        reading.newest = max((reading.newest, *(read_event_id(each) for each in ids if each is not None)))
        found = await self._take(documents, reading)
        found |= await self._read_pages(reading)
        await self._find_unfinished(found)
        reading.gap = False
        self._news.cursor = reading.newest or id_before(read_time(message.get("time")))
        self._more.set()
        self._view.behind = False

    async def _take(self, documents: Iterable[Any], reading: Reading) -> set[str]:
        """Take over goals as they are now; return their ids. Their ends are published, unless they surely were."""
        found = set()
        for document in documents:
            await self._make_room()
            await asyncio.sleep(0)
            try:
                goal = read_goal(self._site, document)
            except ForeignDocumentError as error:
                self._complain(error)
                continue
            found.add(goal.goal_id)
            self._note(goal)
            if reading.tells_of(goal):
                self._news.happenings += ends_of(copy(goal))
            self._more.set()
        return found

    async def _read_pages(self, reading: Reading) -> set[str]:
        """Read the goals of the site, newest first, until those that are known already."""
        found: set[str] = set()
        query = f"limit={PAGE}"
        for _ in range(MAX_PAGES):
            status, document = await self._client.get("/goals", query)
            if status != 200 or not isinstance(document, dict) or not isinstance(document.get("goals"), list):
                raise ForeignDocumentError(f"GET /goals is answered with {status}")
            page = await self._take(document["goals"], reading)
            known = await self._history.known(page)
            found |= page
            cursor = document.get("next_cursor")
            if cursor is None or all(each in known and known[each].status.final for each in page):
                break
            query = f"limit={PAGE}&cursor={quote(str(cursor)[:MAX_CURSOR], safe='')}"
        return found

    async def _find_unfinished(self, found: set[str]) -> None:
        """Ask for the goals that the hub has as running and that the site has not named."""
        running = GoalFilter(statuses=RUNNING, namespace=f"/{self._site}")
        for known in await self._history.page(running, limit=MAX_GOALS):
            if known.goal_id in found:
                continue
            try:
                goal = await self._ask(known.goal_id)
            except ForeignDocumentError as error:
                self._complain(error)
                continue
            if goal is None:
                goal = copy(known)
                goal.lose(GoalError("goal_unknown", "the site no longer knows the goal"), utc_now())
                self._news.happenings += [Happening("status", copy(goal), goal.updated_at)]
            self._note(goal)
            self._news.happenings += ends_of(copy(goal))


def _decode(message: str | bytes) -> dict[str, Any]:
    try:
        document = orjson.loads(message)
    except orjson.JSONDecodeError:
        document = None
    if not isinstance(document, dict):
        raise ForeignDocumentError("a message of its stream is not a JSON object")
    return document
