"""Carries out missions: follows those of this gateway's robots, and makes the moves that the rules say."""

import asyncio
import logging
import uuid
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime

from dock_gateway.core.errors import GatewayError, Unavailable, is_by_stop
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.battery import LEAST_CHARGE, BatteryLimits
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.facts import FactsReader, key_of_try
from dock_gateway.extensions.missions.messages import Messages
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import Cancel, Change, Facts, Send, Sent, Wait, WaitsFor
from dock_gateway.extensions.missions.progress import begins_message, next_move
from dock_gateway.extensions.missions.step_entry import Reason
from dock_gateway.extensions.missions.step_goals import StepGoals
from dock_gateway.extensions.missions.turns import NO_ROBOTS, RobotFacts, find_turns
from dock_gateway.latch.interlock import Interlock
from dock_gateway.stop.last_stops import LastStops
from dock_gateway.storage.shared_entries import SYNC_INTERVAL

log = logging.getLogger(__name__)

# Seconds between two looks at missions that have not ended.
INTERVAL = 1.0
# To which a robot charges that a rule of automatic docking has called back from its mission.
ASKED_CHARGE = 0.8


class MissionRunner:
    """Follows missions.

    Args:
        book: The missions.
        goals: Sends and cancels the goals of steps.
        messages: Calls services, and publishes messages.
        interlock: The latched stops.
        share: The robots that this gateway serves.
        candidates: Returns the robots that may take missions of their groups.
        last_stops: When robots were last stopped.
        facts: Reads what is known of a mission.
        shared: Whether other gateways may follow the same missions.
        clock: Returns the time.
    """

    def __init__(
        self,
        book: MissionBook,
        *,
        goals: StepGoals,
        messages: Messages,
        interlock: Interlock,
        share: Share,
        candidates: Callable[[], Mapping[str, RobotFacts]],
        last_stops: LastStops,
        facts: FactsReader,
        shared: bool,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self.book = book
        self._goals = goals
        self._messages = messages
        self._interlock = interlock
        self._share = share
        self._candidates = candidates
        self._last_stops = last_stops
        self._reader = facts
        self._clock = clock
        self._name = uuid.uuid4().hex if shared else None  # as the one that sends goals
        self._sent: dict[str, Sent] = {}  # calls and messages whose tries this gateway has begun, by their keys
        self._busy: set[str] = set()  # robots
        self._woken = asyncio.Event()
        self._tasks = Tasks("carrying out missions")

    def start(self) -> None:
        """Carry out missions from now on."""
        self._tasks.spawn(self._run())

    def wake(self, *_: object) -> None:
        """Look at the missions now."""
        self._woken.set()

    def on_goal(self, goal: Goal) -> None:
        """Look at the missions if the goal of one has ended, or is lost."""
        if any(mission.active and mission.current.goal_id == goal.goal_id for mission in self.book.all().values()):
            self.wake()

    def on_stop(self, robot: str) -> None:
        """Hold the mission of a robot that is stopped, also if the stop does not stay."""
        self._last_stops.note(robot, self._clock())
        self.wake()

    def on_release(self, robot: str) -> None:
        """Note that the stop of a robot is released, which starts no mission."""
        self._last_stops.note_release(robot, self._clock())
        self.wake()

    def _has_for_groups(self) -> bool:
        """Return whether missions wait for a robot of a group."""
        return any(mission.robot is None and mission.in_queue for mission in self.book.all().values())

    def has_work(self, robot: str) -> bool:
        """Return whether a robot is on a mission that is not held."""
        at_work = (MissionStatus.RUNNING, MissionStatus.CANCELING)
        return any(mission.robot == robot and mission.status in at_work for mission in self.book.all().values())

    def ask_to_charge(self, robot: str, below: float) -> None:
        """Let the robot of a mission that does not say when it returns to charge do so below a charge (0 to 1)."""
        for mission_id, mission in self.book.all().items():
            if mission.robot == robot and mission.status is MissionStatus.RUNNING and mission.limits is None:
                self._tasks.spawn(self._ask(mission_id, mission, below))

    async def _ask(self, mission_id: str, mission: MissionEntry, below: float) -> None:
        limits = BatteryLimits(below=below, charge_to=max(ASKED_CHARGE, below + LEAST_CHARGE))
        try:
            await self.book.change(mission_id, mission, mission.but(asked_battery=limits))
        except Unavailable:
            return  # it is asked again
        self.wake()

    async def close(self) -> None:
        """Follow no more. Goals that were sent go on, and are found again."""
        await self._tasks.close()

    async def _run(self) -> None:
        synced = 0.0
        loop = asyncio.get_running_loop()
        while True:
            self._woken.clear()
            try:
                if self._last_stops.unsaved or loop.time() - synced >= SYNC_INTERVAL:
                    # Stops first: what begins afterwards is refused, and what has begun before is read, and held.
                    await self._last_stops.sync()
                    if await self.book.sync():
                        synced = loop.time()
                self._look()
            except Exception:
                log.exception("while looking at missions")
            try:
                async with asyncio.timeout(INTERVAL if self.book.all() else SYNC_INTERVAL):
                    await self._woken.wait()
            except TimeoutError:
                pass

    def _look(self) -> None:
        """Let each robot go on with its mission, or begin the one whose turn it is."""
        missions = self.book.all()
        turns = find_turns(missions, self._candidates() if self._has_for_groups() else NO_ROBOTS)
        for mission_id, reason in turns.waits.items():
            robot = missions[mission_id].robot
            if robot is None or self._share.covers_robot(robot):
                self.book.set_wait(mission_id, reason)
        for robot, mission_id in turns.on.items():
            if self._share.covers_robot(robot) and robot not in self._busy:
                self._busy.add(robot)
                self._tasks.spawn(self._follow(robot, mission_id))

    async def _follow(self, robot: str, mission_id: str) -> None:
        """Take a mission as far as it goes now."""
        try:
            while (mission := self.book.get(mission_id)) is not None and not mission.status.ended:
                if mission.robot not in (None, robot):
                    return  # another gateway has given it to another robot
                wait = await self._take_step(robot, mission_id, mission)
                if wait is not None:
                    self.book.set_wait(mission_id, wait.reason)
                    self._wake_at(wait.until)
                    return
        except Unavailable:  # of the history: nothing is done that could not be stored
            self.book.set_wait(mission_id, WaitsFor.HISTORY)
        finally:
            self._busy.discard(robot)
            if self.book.get(mission_id) is None:
                self.wake()  # it is the next one's turn

    def _wake_at(self, time: datetime | None) -> None:
        if time is not None and (delay := (time - self._clock()).total_seconds()) < INTERVAL:
            asyncio.get_running_loop().call_later(max(delay, 0.0), self.wake)

    async def _take_step(self, robot: str, mission_id: str, mission: MissionEntry) -> Wait | None:
        """Make one move; return what the mission waits for, or None if it goes on.

        Raises:
            Unavailable: The history does not answer.
        """
        if mission.status is MissionStatus.QUEUED:
            started = progress.start(mission, self._clock(), robot)
            if self._last_stops.any_since(robot, mission.allowed_since):
                started = progress.stop(started)
            return None if await self._change(robot, mission_id, mission, started) else Wait(WaitsFor.TURN)
        facts = await self._facts(mission_id, mission)
        move = next_move(mission, facts, self._clock())
        match move:
            case Change(after):
                changed = await self._change(robot, mission_id, mission, after)
                self._sent.pop(key_of_try(mission_id, mission), None)
                if changed and begins_message(mission, after):
                    self._sent[key_of_try(mission_id, after)] = Sent()
                if facts.goal is not None:
                    self._goals.given_up.discard(facts.goal.goal_id)
                return None
            case Send() if mission.current.is_message:
                await self._send_message(mission_id, mission)
                return None
            case Send():
                return await self._goals.send(mission_id, mission, facts)
            case Cancel(goal):
                await self._goals.cancel(goal)
                return Wait(WaitsFor.GOAL)
            case Wait():
                return move

    async def _change(self, robot: str, mission_id: str, before: MissionEntry, after: MissionEntry) -> bool:
        """Store a change, unless another gateway has made one, or stored a stop; return whether it was stored.

        Raises:
            Unavailable: The history does not answer.
        """
        moves = after.status is MissionStatus.RUNNING
        none_since = self._last_stops.none_since(robot, after.allowed_since) if moves else None
        changed = await self.book.change(mission_id, before, after, dependency=none_since)
        if moves and not changed:
            await self._last_stops.read()
        return changed

    async def _facts(self, mission_id: str, mission: MissionEntry) -> Facts:
        facts = await self._reader.read(mission_id, mission)
        return replace(
            facts,
            given_up=facts.goal is not None and facts.goal.goal_id in self._goals.given_up,
            sent=self._sent.get(key_of_try(mission_id, mission)),
            gateway=self._name,
        )

    async def _send_message(self, mission_id: str, mission: MissionEntry) -> None:
        """Call the service of the present step, or publish its message, and note how that ends."""
        key = key_of_try(mission_id, mission)
        try:
            self._interlock.require_released(mission.its_robot, "missions")
            await self._messages.send(mission.current)
        except GatewayError as error:
            reason = Reason(code=error.code, detail=error.detail)
            self._sent[key] = Sent(over=True, error=reason, by_stop=is_by_stop(error))
        except Exception:
            log.exception("while sending the message of a mission")
            self._sent[key] = Sent(over=True, error=progress.INTERRUPTED)
        else:
            self._sent[key] = Sent(over=True)
