"""Gateways that carry out missions in virtual time, with action servers of the test, for `test_runner`."""

import asyncio
from collections.abc import Callable
from datetime import datetime, timedelta
from types import SimpleNamespace
from typing import Any, cast

from dock_gateway.core.battery import BatteryReading, PowerSupply
from dock_gateway.core.errors import Conflict, GatewayError, NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.share import EVERYTHING
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.facts import FactsReader
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.notices import Notices
from dock_gateway.extensions.missions.places.place import PlaceEntry
from dock_gateway.extensions.missions.places.places import Places
from dock_gateway.extensions.missions.runner import MissionRunner
from dock_gateway.extensions.missions.step_entry import StepEntry
from dock_gateway.extensions.missions.step_goals import StepGoals
from dock_gateway.extensions.missions.turns import RobotFacts
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.storage.shared_entries import SharedBook
from tests.extensions.missions.examples import NOON, queued
from tests.support.entries import EntriesInMemory, SharedStore


class Server:
    """What runners know as the actions, the goals, and the history of the goals' keys.

    Attributes:
        goals: The goals, by their keys.
        takes: Seconds that a goal takes; None: until it is canceled.
        refuses: What a submission raises, one after the other.
        messages: How many calls and messages were sent.
        fails: How they fail, one after the other.
    """

    def __init__(self, *, shared: bool = False) -> None:
        self.shared = shared
        self.goals: dict[str, Goal] = {}
        self.takes: float | None = 10.0
        self.refuses: list[GatewayError] = []
        self.messages = 0
        self.fails: list[Exception] = []
        self.there = True
        self.read: Any = None  # the goal that was read last
        self.listeners: list[Callable[[Goal], None]] = []

    async def read_goal(self, request: object, _: str) -> object:
        self.read = request
        return request

    def read_docking_request(self, request: object, _: str) -> object:
        return request

    async def require(self, _: object, request: object) -> None:
        """Have every dock but one."""
        if request == {"dock_id": "nowhere"}:
            raise NotFound("no dock", code="dock_not_found")

    async def submit(self, _: object, key: str, *, sender: object) -> Goal:
        assert sender is None
        if key not in self.goals:
            await asyncio.sleep(0.01)
            if self.refuses:
                raise self.refuses.pop(0)
            made = Goal(f"goal-{len(self.goals)}", "/dock", "pkg/action/T", NOON)
            made.status = GoalStatus.EXECUTING
            self.goals.setdefault(key, made)
            if self.takes is not None:
                asyncio.get_running_loop().call_later(self.takes, self.end, made)
        return self.goals[key]

    def end(self, goal: Goal, status: GoalStatus = GoalStatus.SUCCEEDED) -> None:
        if not goal.status.final:
            goal.status = status
            for listener in self.listeners:
                listener(goal)

    async def cancel(self, goal: Goal) -> None:
        if goal.status is not GoalStatus.LOST:
            self.end(goal, GoalStatus.CANCELED)

    async def get(self, goal_id: str) -> Goal:
        for goal in self.goals.values():
            if goal.goal_id == goal_id:
                return goal
        raise NotFound("no goal")

    async def by_key(self, key: str) -> Goal | None:
        return self.goals.get(key)

    async def send(self, step: StepEntry) -> None:
        """Carry out a call or a message, which takes a second."""
        self.messages += 1
        await asyncio.sleep(1)
        if self.fails:
            raise self.fails.pop(0)

    def running(self) -> list[Goal]:
        return [goal for goal in self.goals.values() if not goal.status.terminal]


class Robots:
    """The robot `/`, whose battery is not known until a test says what it is."""

    def __init__(self) -> None:
        self.battery = SimpleNamespace(age=None, stale_since=None, reading=BatteryReading())
        self.robot = SimpleNamespace(namespace="/", battery=self.battery)

    def say(self, percentage: float, power_supply: PowerSupply) -> None:
        """Let the battery have this charge."""
        self.battery.age, self.battery.reading = 0.1, BatteryReading(power_supply, percentage)

    def __contains__(self, _: str) -> bool:
        return True

    def get(self, _: str) -> Any:
        return self.robot

    owner = get


def now() -> datetime:
    """Return the virtual time."""
    return NOON + timedelta(seconds=asyncio.get_running_loop().time())


class Site:
    """Gateways that share a history, with one robot, `/`."""

    def __init__(self, gateways: int = 1) -> None:
        self.store, self.past = SharedStore[MissionEntry](), EntriesInMemory[MissionEntry]()
        self.places = Places(SharedBook(EntriesInMemory[PlaceEntry](), "place", 10))
        self.stops = SharedStore[LastStop]()
        self.last_stops: list[LastStops] = []
        self.server = Server(shared=gateways > 1)
        self.robots = Robots()
        self.held = False
        self.free: dict[str, RobotFacts] = {}
        self.runners = [self.open() for _ in range(gateways)]

    def open(self) -> MissionRunner:
        server = self.server
        book = MissionBook(Fanout(queue_limit=1), self.store, self.past, lambda *_: True)
        book.notices = Notices(now)
        action = SimpleNamespace(
            on_graph=True,
            submitter=server,
            canceler=server,
            read_goal=server.read_goal,
            read_docking_request=server.read_docking_request,
        )
        self.last_stops.append(LastStops(self.stops))
        actions: Any = SimpleNamespace(get=lambda _: action if server.there else None, running=server.running)
        interlock: Any = SimpleNamespace(holds=lambda _: self.held, require_released=self.require_released)
        facts = FactsReader(
            robots=cast("Any", self.robots),
            actions=actions,
            goals=cast("Any", server),
            history=cast("Any", server),
            places=self.places,
            interlock=interlock,
            last_stops=self.last_stops[-1],
            docked=lambda _: None,
        )
        goals = StepGoals(
            book,
            actions=actions,
            robot_actions=cast("Any", SimpleNamespace(docking_name=lambda *_: "/dock")),
            docks=cast("Any", server),
            robots=cast("Any", self.robots),
            last_stops=self.last_stops[-1],
            clock=now,
        )
        runner = MissionRunner(
            book,
            goals=goals,
            messages=cast("Any", server),
            interlock=interlock,
            share=EVERYTHING,
            candidates=lambda: self.free,
            last_stops=self.last_stops[-1],
            facts=facts,
            shared=server.shared,
            clock=now,
        )
        server.listeners.append(runner.on_goal)
        runner.start()
        return runner

    def require_released(self, robot: str, _: str) -> None:
        if self.held:
            raise Conflict(f"{robot} is stopped", code="stop_latched")

    async def add(self, *steps: dict[str, Any], mission_id: str = "a", **fields: Any) -> None:
        await self.runners[0].book.add(mission_id, queued(*steps, **fields))
        self.runners[0].wake()

    async def ended(self, mission_id: str = "a") -> MissionEntry:
        """Wait for the end of a mission."""
        async with asyncio.timeout(1e6):
            while mission_id not in self.past.known:  # noqa: ASYNC110 - whichever gateway ends it
                await asyncio.sleep(1.0)
        return self.past.known[mission_id]
