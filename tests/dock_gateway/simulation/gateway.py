"""One life of a gateway: the product's own parts, on a simulated network and database."""

import asyncio
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from contextvars import Context
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from dock_gateway.core.event import Event, moment, notice, robot_event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter, GoalFilter
from dock_gateway.core.goal import Goal, ResultAnswer
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals import unfinished
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.http.parts import Parts
from dock_gateway.ros.status import StatusReport
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.retention import Limits
from dock_gateway.streams.current_state import CurrentState
from tests.dock_gateway.simulation.chance import TICK, Chance
from tests.dock_gateway.simulation.database import Disk, SimulatedDatabase, SimulatedSpool
from tests.dock_gateway.simulation.process import Process
from tests.dock_gateway.simulation.server import ActionServer

ACTIONS = ("/one", "/two")
FOREVER = Limits(10**9, 10**12, 10**9, 10**12, 10**9, 10**9)


class Call:
    """A request for a result on its way."""

    def __init__(self) -> None:
        self.response: asyncio.Future[ResultAnswer] = asyncio.get_running_loop().create_future()

    def forget(self) -> None:
        self.response.cancel()


class Port:
    """An action as one gateway reaches it."""

    action_type = "pkg/action/Move"

    def __init__(self, gateway: "Gateway", action_name: str) -> None:
        self.action_name = action_name
        self._gateway = gateway

    def request_result(self, goal_id: str) -> Call:
        call, gateway, server = Call(), self._gateway, self._gateway.server

        def answered(answer: ResultAnswer) -> None:
            if not call.response.done():
                call.response.set_result(answer)

        def asked() -> None:
            server.await_end(goal_id, lambda answer: gateway.carry("answers", lambda: answered(answer)))

        if self.action_name in gateway.heard:  # else the request is lost, as before the server is discovered
            gateway.chance.later(gateway.chance.latency(), asked)
        return call


class GoalsOnly:
    """The present state, without robots."""

    def __init__(self, history: History) -> None:
        self._history = history

    async def snapshot(self, _: EventFilter, position: str) -> Event:
        goals = await self._history.page(GoalFilter(), limit=20)
        lists: dict[str, list[Any]] = {"robots": [], "alerts": [], "approvals": []}
        documents = [goal.document() for goal in goals]
        return notice("snapshot", moment(time.time_ns()), position=position, goals=documents, **lists)

    def events(self, _: EventFilter) -> list[Event]:
        return []


class Gateway(Process):
    """One life of a gateway: the parts of the product that deal with goals and their events."""

    def __init__(
        self, chance: Chance, server: ActionServer, disk: Disk, spool: dict[int, list[bytes]], name: str
    ) -> None:
        super().__init__(chance, name)
        self.server = server
        self._disk = disk
        self._spool = spool
        self._again = self.chance.loop.time() > 0.1  # one that starts with the run knows the action server at once
        self.heard: set[str] = set()
        self.trackers: dict[str, GoalTracker] = {}
        self._busy_until: defaultdict[str, float] = defaultdict(float)

    async def start(self) -> None:
        spool: Any = SimulatedSpool(self._spool)
        shared = self.chance.faults.gateways > 1
        database = SimulatedDatabase(self._disk, self, self.chance.database_delay, shared=shared)
        with patch("dock_gateway.storage.history.open_database", lambda _: database):
            history = History("", spool, max_waiting=1000, limits=FOREVER)
        await history.open()
        self.history = history
        self.fanout = Fanout(queue_limit=1000, keep=history.record_event, newest=history.newest)
        self.fanout.line.on_want.append(history.follow(self.fanout.line.allow))
        settings = SimpleNamespace(heartbeat_interval=3600.0)
        self.parts = Parts(
            {Fanout: self.fanout, History: history, Settings: settings, CurrentState: GoalsOnly(history)}
        )
        actions: Any = self
        asyncio.create_task(unfinished.take_over_unfinished(actions, history))  # noqa: RUF006 - noted
        self._expected: list[Goal] = []
        for action in ACTIONS:
            asyncio.create_task(self._discover(action))  # noqa: RUF006 - noted
        self.ready = True
        self.chance.say(self.name, "ready")

    async def _discover(self, action: str) -> None:
        """Join an action, whose topics and services are discovered one by one."""
        discovery = self.chance.faults.discovery if self._again else 0.0
        await asyncio.sleep(self.chance.random.uniform(0, discovery))
        port: Any = Port(self, action)
        self.trackers[action] = GoalTracker(port, self.fanout, self.history, PendingFacts(0.05))
        expected, self._expected = self._expected, []
        self.expect(expected)
        links = [lambda: self.heard.add(action), lambda: self.server.listen(self, action, "status")]
        links.append(lambda: self.server.listen(self, action, "feedback"))
        for link in links:
            self.chance.later(self.chance.random.uniform(0, discovery), link)

    def expect(self, goals: list[Goal]) -> None:
        """As `ActionRegistry.expect`."""
        for goal in goals:
            if goal.action_name in self.trackers:
                self.trackers[goal.action_name].take_up(goal)
            else:
                self._expected.append(goal)

    def carry(self, link: str, message: Callable[[], object]) -> None:
        """Bring a message here; those of one link arrive in their order."""
        now = self.chance.loop.time()
        at = max(now + self.chance.latency() + self.chance.lag_of(self.name), self._busy_until[link] + TICK)
        self._busy_until[link] = at

        def arrive() -> None:
            if not self.dead:
                with self.running():
                    message()

        self.chance.loop.call_at(at, arrive, context=Context())

    async def send(self, goal_id: str, action: str) -> None:
        """Send a goal, as `Delivery` does."""
        tracker = self.trackers[action]
        goal = tracker.new_goal(goal_id, moment(self.chance.loop.time_ns()), "gateway")
        goal.goal = b"{}"
        await self.history.add(goal)
        tracker.apply(GoalMachine.add, goal)
        accepted: asyncio.Future[int] = self.chance.loop.create_future()
        server = self.server

        def arrive() -> None:
            stamp = server.take(goal_id, action)
            self.carry("answers", lambda: accepted.done() or accepted.set_result(stamp))

        self.chance.later(self.chance.latency(), arrive)
        tracker.apply(GoalMachine.accept, goal, await accepted)
        await self.history.seal(goal, [])

    def on_status(self, action: str, reports: list[StatusReport], stamp: int) -> None:
        self.trackers[action].on_status(reports, stamp)

    def on_feedback(self, action: str, goal_id: str, feedback: bytes, stamp: int) -> None:
        self.trackers[action].on_feedback(goal_id, feedback, stamp)

    def on_battery(self, stamp: int) -> None:
        """Take the state of the robot's battery."""
        event = robot_event("battery", {}, self.fanout.clock.stamp(stamp), stamp, robot="/")
        self.fanout.publish(event)


@contextmanager
def simulated() -> Iterator[None]:
    """Let everything have the time of the simulation, and the limits of the product, not those of tests."""
    with ExitStack() as stack:
        for name, value in (
            ("goals.unfinished.utc_now", lambda: moment(time.time_ns())),
            ("storage.history.OPEN_TIMEOUT", 2.0),
            ("storage.writer.ANSWER_TIMEOUT", 0.1),
        ):
            stack.enter_context(patch(f"dock_gateway.{name}", value))
        yield
