"""Follows who stands at the shared docks: reads what is seen of the robots, and stores what that means."""

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import orjson

from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.chargers import policy
from dock_gateway.extensions.chargers.dock import Hold
from dock_gateway.extensions.chargers.policy import GoalState, Seen
from dock_gateway.extensions.chargers.shared_docks import SharedDocks
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.goals.goals import Goals
from dock_gateway.storage.shared_entries import SYNC_INTERVAL

log = logging.getLogger(__name__)

# Seconds between two looks at the robots.
INTERVAL = 1.0
# Seconds for which a robot must have been seen off any dock before its own one is free.
AWAY_FOR = 10.0
# Seconds for which a robot must have been on no mission until its waiting place is free: a gateway that has just
# started has not read the missions yet.
IDLE_FOR = 10.0
# Codes of goals that a stop has ended: the dock is not to blame.
BY_STOP = ("stopped", "stop_latched")
# The code of a goal whose robot stands on the dock, and is not charged.
ON_DOCK = "failed_to_charge"


@dataclass(frozen=True)
class Trouble:
    """What is wrong at the docks as this gateway sees it.

    Attributes:
        silent: Since when a robot that has a dock was not heard, by the dock.
        contested: The robot that is at a dock that another one has, by the dock, and since when.
    """

    silent: Mapping[str, datetime]
    contested: Mapping[str, tuple[str, datetime]]


class DockWatch:
    """Follows the docks that this gateway's robots have.

    Args:
        docks: The shared docks.
        fleet: The state of the robots.
        goals: Their goals.
        share: The robots that this gateway serves.
        failures: Failed dockings in a row after which a dock is out of order; 0: never.
        clock: Returns the time.

    Attributes:
        on_look: Called after each look.
        trouble: What is wrong.
    """

    def __init__(
        self,
        docks: SharedDocks,
        fleet: Fleet,
        goals: Goals,
        share: Share,
        *,
        failures: int = 3,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self._docks = docks
        self._fleet = fleet
        self._goals = goals
        self._share = share
        self._failures = failures
        self.on_look = Listeners[[]]("shared docks were looked at")
        self._clock = clock
        self.trouble = Trouble({}, {})
        self._away_since: dict[str, float] = {}  # robots
        self._idle_since: dict[str, float] = {}  # robots that wait, and are on no mission
        self._woken = asyncio.Event()
        self._tasks = Tasks("following shared docks")

    def start(self) -> None:
        """Follow the docks from now on."""
        self._tasks.spawn(self._run())

    def wake(self, *_: object) -> None:
        """Look at the docks now."""
        self._woken.set()

    async def close(self) -> None:
        """Follow no more. Who has a dock is stored, and followed again after a restart."""
        await self._tasks.close()

    async def _run(self) -> None:
        synced = float("-inf")
        loop = asyncio.get_running_loop()
        while True:
            self._woken.clear()
            try:
                if loop.time() - synced >= SYNC_INTERVAL and await self._docks.sync():
                    synced = loop.time()
                if self._docks.book.all():
                    await self.look()
                self.on_look()
            except Unavailable:
                pass  # it is looked at again
            except Exception:
                log.exception("while looking at shared docks")
            try:
                async with asyncio.timeout(INTERVAL if self._docks.book.all() else SYNC_INTERVAL):
                    await self._woken.wait()
            except TimeoutError:
                pass

    async def look(self) -> None:
        """Look at each dock once.

        Raises:
            Unavailable: The history does not answer.
        """
        states = {state.name: state for state in self._fleet.states()}
        self._note_away(states)
        await self._adopt(states)
        for dock_id in self._docks.book.all():
            record = self._docks.records.get(dock_id)
            if record is not None and record.hold is not None and self._is_ours(record.hold):
                after = policy.follow(
                    record, await self._seen(dock_id, record.hold, states), self._clock(), self._failures
                )
                if after != record:
                    await self._docks.change(dock_id, record, after)
        await self._leave_places()
        self._note_silent(states)

    async def _leave_places(self) -> None:
        """Let robots have no waiting place whose missions have ended, or are held."""
        now, waits = time.monotonic(), self._docks.waits.all()
        idle = [each for each in waits if self._share.covers_robot(each) and not self._docks.robots.is_at_work(each)]
        self._idle_since = {robot: self._idle_since.get(robot, now) for robot in idle}
        for robot, since in self._idle_since.items():
            if now - since >= IDLE_FOR:
                await self._docks.leave_place(robot)

    def _is_ours(self, hold: Hold) -> bool:
        return hold.robot is not None and self._share.covers_robot(hold.robot)

    # ------------------------------------------------------------------ what is seen

    def _note_away(self, states: Mapping[str, RobotState]) -> None:
        now = time.monotonic()
        away = {name for name, state in states.items() if state.docked is False and not state.on_dock and heard(state)}
        self._away_since = {name: self._away_since.get(name, now) for name in away}

    def _is_away(self, robot: str, hold: Hold) -> bool:
        since = self._away_since.get(robot)
        stood = (self._clock() - hold.since_at).total_seconds() if hold.standing else AWAY_FOR
        return since is not None and min(time.monotonic() - since, stood) >= AWAY_FOR

    async def _seen(self, dock_id: str, hold: Hold, states: Mapping[str, RobotState]) -> Seen:
        robot = hold.robot or ""
        state = states.get(robot)
        goals = {goal_id: await self._goal_state(goal_id, state) for goal_id in hold.goal_ids}
        others = [
            record.hold
            for other, record in self._docks.records.all().items()
            if other != dock_id and record.hold is not None and record.hold.robot == robot and record.hold.standing
        ]
        return Seen(
            goals,
            docked=state is not None and state.on_dock and not others,  # if it stands at one, it is that
            away=self._is_away(robot, hold),
            elsewhere=any(other.since_at > hold.since_at for other in others),
        )

    async def _goal_state(self, goal_id: str, state: RobotState | None) -> GoalState:
        try:
            goal = await self._goals.get(goal_id)
        except NotFound:
            return GoalState.MISSING
        match goal.status:
            case GoalStatus.SUCCEEDED:
                return GoalState.SUCCEEDED
            case GoalStatus.ABORTED if goal.error is not None and goal.error.code == ON_DOCK:
                return GoalState.SUCCEEDED
            case GoalStatus.ABORTED if goal.error is None or goal.error.code not in BY_STOP:
                return GoalState.ABORTED
            case GoalStatus.LOST:
                followed = state is not None and heard(state) and goal_id not in {each.goal_id for each in state.lost}
                return GoalState.ENDED if followed else GoalState.LOST
        return GoalState.ENDED if goal.status.final else GoalState.RUNS

    def _note_silent(self, states: Mapping[str, RobotState]) -> None:
        now, silent = self._clock(), {}
        for dock_id, record in self._docks.records.all().items():
            hold = record.hold
            if hold is None or not self._is_ours(hold) or dock_id not in self._docks.book.all():
                continue
            state = states.get(hold.robot or "")
            lost = state is not None and any(goal.goal_id in hold.goal_ids for goal in state.lost)
            if state is None or lost or not heard(state):
                silent[dock_id] = self.trouble.silent.get(dock_id, now)
        self.trouble = Trouble(silent, self.trouble.contested)

    # ------------------------------------------------------------------ robots that did not ask

    async def _adopt(self, states: Mapping[str, RobotState]) -> None:
        """Note robots at shared docks for which no goal has asked: sent from ROS, or before the dock was shared."""
        contested: dict[str, tuple[str, datetime]] = {}
        for robot, state in states.items():
            for dock_id, goal in self._at(state):
                record = self._docks.records.get(dock_id) or policy.FREE
                running = goal.goal_id if not goal.status.terminal else None
                if running is None and record.cleared_at is not None and goal.updated_at <= record.cleared_at:
                    continue
                if record.hold is None:
                    now = self._clock()
                    after = (
                        policy.stand(record, robot, None, now)
                        if running is None
                        else policy.reserve(record, robot, running, now)
                    )
                    await self._docks.change(dock_id, record, after)
                elif record.hold.robot != robot:
                    contested[dock_id] = robot, self.trouble.contested.get(dock_id, (robot, self._clock()))[1]
                elif running is not None and running not in record.hold.goal_ids:
                    await self._docks.change(dock_id, record, policy.reserve(record, robot, running, self._clock()))
        self.trouble = Trouble(self.trouble.silent, contested)

    def _at(self, state: RobotState) -> list[tuple[str, Goal]]:
        """Return the shared docks that a robot drives to or stands at, each with the docking goal that says so."""
        last, goals = state.last_goal, [goal for goal in state.goals if goal.verb == "dock"]
        if not goals and state.on_dock and last is not None and last.status is GoalStatus.SUCCEEDED:
            goals = [last]  # a goal that runs says more: the robot may touch the dock of that one already
        found = ((self._dock_of(goal), goal) for goal in goals)
        return [(dock_id, goal) for dock_id, goal in found if dock_id in self._docks.book.all()]

    def _dock_of(self, goal: Goal) -> str:
        action = self._docks.actions.get(goal.action_name)
        if goal.verb != "dock" or goal.goal is None or action is None or action.adapter is None:
            return ""
        fields: Any = orjson.loads(goal.goal)
        return action.adapter.dock_of(fields) or ""


def heard(state: RobotState) -> bool:
    """Return whether a robot is heard: its battery is, or its docking server answers."""
    fresh = state.battery.age is not None and state.battery.stale_since is None
    return fresh or (state.dock is not None and state.dock.available and state.dock.answering)
