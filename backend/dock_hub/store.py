"""Stores what sites report, and publishes what is new: each event is stored once and published once.

One task writes for all sites: what arrives during a transaction is the next one. So the ids of events, which this hub's
clock gives them, are published in their order.
"""

import asyncio
import contextlib
import logging
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from datetime import datetime

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event, nanoseconds, result_event, status_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal
from dock_gateway.core.tasks import Tasks
from dock_hub.fields import ForeignDocumentError
from dock_hub.goal_documents import Happening
from dock_hub.mirror import Mirror, MirrorBatch, RefusedError

log = logging.getLogger(__name__)

# Seconds between two attempts while the database does not answer.
RETRY_INTERVAL = 0.5
# Sites whose news are one transaction.
MAX_TOGETHER = 100


@dataclass
class SiteReports:
    """The reports of a site, in their order.

    Attributes:
        site: The site.
        goals: Goals as they are now, by id.
        happenings: How they changed.
        cursor: Id of the site's last event among these; None if that does not move.
        size: Bytes of the messages of the goals.
    """

    site: str
    goals: dict[str, Goal] = field(default_factory=dict)
    happenings: list[Happening] = field(default_factory=list)
    cursor: str | None = None
    size: int = 0

    def parts(self) -> Iterator["SiteReports"]:
        """Yield it goal by goal, and last the cursor."""
        for goal_id, goal in self.goals.items():
            yield SiteReports(
                self.site, {goal_id: goal}, [each for each in self.happenings if each.goal.goal_id == goal_id]
            )
        yield SiteReports(self.site, cursor=self.cursor)

    def __bool__(self) -> bool:
        return bool(self.goals or self.happenings or self.cursor)


class HubStore:
    """Writes the news of all sites.

    Args:
        mirror: Stores them.
        fanout: Receives the events that are new.

    Attributes:
        mirror: Knows how far each site was read, too.
    """

    def __init__(self, mirror: Mirror, fanout: Fanout) -> None:
        self.mirror = mirror
        self._fanout = fanout
        self._waiting: asyncio.Queue[tuple[SiteReports, asyncio.Future[None]]] = asyncio.Queue()
        self._tasks = Tasks("storing the news of sites")
        self._tasks.spawn(self._run())

    async def keep(self, news: SiteReports) -> None:
        """Store the news of a site and publish its events that are new. Waits for a database that is away.

        Raises:
            ForeignDocumentError: A goal has the id of a goal of another site. All but that one is kept.
        """
        done = asyncio.get_running_loop().create_future()
        await self._waiting.put((news, done))
        await done

    async def close(self) -> None:
        """Store no more."""
        await self._tasks.close()

    async def _run(self) -> None:
        while True:
            together = [await self._waiting.get()]
            while not self._waiting.empty() and len(together) < MAX_TOGETHER:
                together.append(self._waiting.get_nowait())
            try:
                await self._keep([news for news, _ in together])
            except Exception:  # noqa: BLE001 - one of them is to blame, and only that one is refused
                for news, done in together:
                    await self._keep_alone(news, done)
            else:
                for _, done in together:
                    _settle(done)

    async def _keep_alone(self, news: SiteReports, done: "asyncio.Future[None]") -> None:
        try:
            await self._keep([news])
        except RefusedError as error:
            await self._keep_the_rest(news)
            _settle(done, ForeignDocumentError(str(error)))
        except Exception as error:
            log.exception("while storing the news of %s", news.site)
            _settle(done, error)
        else:
            _settle(done)

    async def _keep_the_rest(self, news: SiteReports) -> None:
        """Keep what can be kept, goal by goal, and then the cursor: else the site would send it again and again."""
        for part in news.parts():
            with contextlib.suppress(RefusedError):
                await self._keep([part])

    async def _keep(self, every: Sequence[SiteReports]) -> None:
        batch: MirrorBatch | None = None
        while True:
            try:
                if batch is None:
                    batch = await self._prepare(every)
                new = await self.mirror.take(batch)
            except Unavailable as error:
                log.warning("%s; the news of sites waits", error.detail)
                await asyncio.sleep(RETRY_INTERVAL)
            else:
                break
        for event in batch.events:
            if event.id in new:
                self._fanout.publish(event)

    async def _prepare(self, every: Sequence[SiteReports]) -> MirrorBatch:
        """Give ids to the events that are new. It is done once: what is written again has the same ids."""
        now = utc_now()
        happened: dict[str, Happening] = {}
        for news in every:
            for happening in news.happenings:
                happened.setdefault(_key(news.site, happening), happening)
        for key in await self.mirror.known_keys(list(happened)):
            del happened[key]
        goals: dict[str, Goal] = {}
        for goal in (goal for news in every for goal in news.goals.values()):
            if goals.setdefault(goal.goal_id, goal).action_name != goal.action_name:
                raise RefusedError(f"two sites have a goal with the id {goal.goal_id}")
            goals[goal.goal_id] = arrived(goal, now)
        events = []
        for key, happening in happened.items():
            shown = replace(happening, goal=arrived(happening.goal, now))
            event = _event(shown, self._fanout.clock.stamp(nanoseconds(happening.at)))
            events.append(replace(event, key=key))
            if happening.goal.goal_id in goals:
                goals[happening.goal.goal_id].last_event_id = event.id
        cursors = {news.site: news.cursor for news in every if news.cursor is not None}
        return MirrorBatch(list(goals.values()), events, cursors)


def arrived(goal: Goal, now: datetime) -> Goal:
    """Return a copy of a goal with no time later than its arrival: the clock of a site may be wrong.

    Else goals of a site with a later clock would be above all others in lists, and outlive them.
    """
    goal = copy(goal)
    goal.created_at, goal.updated_at = min(goal.created_at, now), min(goal.updated_at, now)
    goal.finished_at = None if goal.finished_at is None else min(goal.finished_at, now)
    return goal


def _event(happening: Happening, stamp_ns: int) -> Event:
    make = status_event if happening.kind == "status" else result_event
    return make(copy(happening.goal), stamp_ns, nanoseconds(happening.at))


def _key(site: str, happening: Happening) -> str:
    """Return the key of an event: the site, and what is the same at each gateway of the site. A goal ends once."""
    return f"{site}:{_event(happening, nanoseconds(happening.at)).key}"


def _settle(done: "asyncio.Future[None]", error: Exception | None = None) -> None:
    if not done.done():
        done.set_result(None) if error is None else done.set_exception(error)
