"""The shared docks: each goal to one asks for it here, whatever door it came through, and gets it or is refused."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any

import orjson

from dock_gateway.core.access import Principal
from dock_gateway.core.dock_adapters.adapter import Fields
from dock_gateway.core.errors import Conflict, DockOccupied, GatewayError, NotFound, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.chargers import policy
from dock_gateway.extensions.chargers.distances import Distances
from dock_gateway.extensions.chargers.dock import DockEntry, DockPose, DockRecord, WaitEntry
from dock_gateway.extensions.chargers.policy import Ask, Obstacle
from dock_gateway.goals.action import Action
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries

log = logging.getLogger(__name__)

MAX_DOCKS = 200
# How often a reservation is tried that others have come before.
TRIES = 10
# A robot that waits is stored again after so long, in seconds: well before `policy.ASKS_WITHIN`.
NOTED_FOR = 10.0


class SharedDocks:
    """The shared docks of all gateways that share the history.

    Args:
        book: The docks, as people have entered them.
        records: What has happened at each.
        waits: The robots that wait, by their names.
        robots: The robots.
        actions: All actions.
        docks: The docks that the robots' docking servers know.
        labels: The groups of the robots.
        distances: Says how far robots are from docks.
        can_drive: Returns whether the robot of a goal that waits for its dock may drive to a waiting place.
        by_charge: Whether the robot with the lowest charge comes first.
        clock: Returns the time.
    """

    def __init__(
        self,
        book: SharedBook[DockEntry],
        records: SharedEntries[DockRecord],
        waits: SharedEntries[WaitEntry],
        *,
        robots: RobotRegistry,
        actions: ActionRegistry,
        docks: Docks,
        labels: RobotLabels,
        distances: Distances,
        can_drive: Callable[[Goal], bool],
        by_charge: bool = False,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self.book = book
        self.records = records
        self.waits = waits
        self.robots = robots
        self.actions = actions
        self.by_charge = by_charge
        self._docks = docks
        self._labels = labels
        self._distances = distances
        self._can_drive = can_drive
        self._clock = clock

    async def sync(self) -> bool:
        """Read what other gateways have changed; return False if the history does not answer."""
        if not await self.book.sync():
            return False
        return not self.book.all() or (await self.records.sync() and await self.waits.sync())

    async def replace(self, dock_id: str, dock: DockEntry, condition: Condition = UNCONDITIONAL) -> bool:
        """Store a shared dock, new or changed; return whether it is new.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the dock is what it was.
        """
        new = await self.book.replace(dock_id, dock, condition=condition)
        log.info("shared dock %s stored, by %s", dock_id, dock.changed_by)
        return new

    async def remove(self, dock_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a shared dock, with what has happened there. Goals to it go on.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `shared_dock_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the dock is still there.
        """
        await self.book.remove(dock_id, condition)
        await self.records.store(dock_id, None, lambda _: None)
        log.info("shared dock %s removed", dock_id)

    async def change(self, dock_id: str, before: DockRecord, after: DockRecord) -> bool:
        """Store what has happened at a dock, unless something else was stored first; return whether it was stored.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """

        def check(stored: Mapping[str, DockRecord]) -> None:
            if stored.get(dock_id, policy.FREE) != before:
                raise Conflict("it was changed meanwhile")

        try:
            await self.records.store(dock_id, after, check)
        except Conflict:
            await self.records.read()
            return False
        if before.hold != after.hold:
            log.info("shared dock %s: %s", dock_id, _describe(after))
        if after.out_of_order_at is not None and before.out_of_order_at is None:
            log.warning("shared dock %s is out of order: %s", dock_id, after.note)
        return True

    # ------------------------------------------------------------------ goals

    async def admit(self, sender: Principal | None, goal: Goal) -> Fields | None:
        """Reserve the dock of a goal before it is sent; return its message with the dock, if it named none.

        Raises:
            DockOccupied: Another robot has it, or all of those that the robot's docking server knows.
            Conflict: It is out of order (`dock_out_of_order`), or not for this robot (`dock_not_for_robot`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if goal.verb != "dock" or goal.goal is None or not self.book.all():
            return None
        action, robot = self.actions.get(goal.action_name), self.robots.owner(goal.action_name)
        if action is None or action.adapter is None or robot is None:
            return None
        fields = orjson.loads(goal.goal)
        named = action.adapter.dock_of(fields)
        if named is None:
            return None
        docks = {named: None} if named else await self._listed(action)
        if not any(dock_id in self.book.all() for dock_id in docks):
            return None
        ask = Ask(robot.namespace, tuple(docks), tuple(self._labels.get(robot.namespace).groups))
        dock_id = await self._reserve(ask, docks, goal, UNLIMITED if sender is None else sender.grant.own)
        return None if named else action.adapter.at_dock(fields, dock_id)

    async def _listed(self, action: Action) -> dict[str, DockPose | None]:
        """Return the docks that a robot's docking server knows, and where they are; none if it does not say."""
        try:
            found = await self._docks.document(action.name, action.family, action.default_dock)
        except Unavailable:
            return {}
        return {each["dock_id"]: self._place(each) for each in found["docks"]}

    def _place(self, listed: Mapping[str, Any]) -> DockPose | None:
        """Return where a dock is, as it was entered here, or as a docking server says."""
        shared = self.book.get(listed["dock_id"])
        if shared is not None and shared.pose is not None:
            return shared.pose
        return None if listed["pose"] is None else DockPose(frame=listed["frame"] or "map", **listed["pose"])

    async def _reserve(self, ask: Ask, docks: Mapping[str, DockPose | None], goal: Goal, grant: Grant) -> str:
        obstacles: dict[str, Obstacle] = {}
        distances: dict[str, float] | None = None
        for _ in range(TRIES):
            records, waits, now = await self.records.read(), await self.waits.read(), self._clock()
            free, obstacles = policy.choices(ask, self.book.all(), records, waits, now, by_charge=self.by_charge)
            if not free:
                break
            placed = {name: pose for name in free if (pose := docks[name]) is not None}
            if len(placed) > 1 and distances is None:
                distances = await self._measure(ask.robot, placed)
                continue  # it takes a moment, in which others may have come
            dock_id = policy.best(ask, free, records, distances or {})
            if dock_id not in self.book.all():
                await self._end_wait(ask.robot)
                return dock_id
            record = records.get(dock_id, policy.FREE)
            if await self.change(dock_id, record, policy.reserve(record, ask.robot, goal.goal_id, now)):
                await self._end_wait(ask.robot)
                return dock_id
            obstacles = {dock_id: Obstacle.OCCUPIED}
        refusal = self._refusal(ask, obstacles, grant)
        if isinstance(refusal, DockOccupied) and goal.origin == "automation":
            place = await self._wait(replace(ask, drives=self._can_drive(goal)))
            if place is not None:
                refusal.extra["wait_at"] = {"frame": place.frame, "x": place.x, "y": place.y, "yaw": place.theta}
        raise refusal

    async def _measure(self, robot: str, docks: Mapping[str, DockPose]) -> dict[str, float]:
        """Return how far a robot is from docks, of those for which that is known."""
        try:
            return await self._distances.measure(robot, docks)
        except GatewayError as error:
            log.warning("which dock is the nearest to %s is not known: %s", robot, error.detail)
            return {}

    async def _wait(self, ask: Ask) -> DockPose | None:
        """Note that a robot waits, which it does as long as it asks again; return where; None: where it is."""
        now, known = self._clock(), self.waits.get(ask.robot)
        entry = policy.waits_for(ask, self.book.all(), self.waits.all(), now)
        same = known is not None and known.model_copy(update={"asked_at": now}) == entry
        if known is not None and same and (now - known.asked_at).total_seconds() < NOTED_FOR:
            return entry.wait_at

        def check(stored: Mapping[str, WaitEntry]) -> None:
            if policy.waits_for(ask, self.book.all(), stored, now).wait_at != entry.wait_at:
                raise Conflict("another robot has that place meanwhile")

        charged = entry.model_copy(update={"battery": self._charge(ask.robot)})
        try:
            await self.waits.store(ask.robot, charged, check)
        except Conflict:
            await self.waits.read()
            return None  # it asks again
        return entry.wait_at

    async def leave_place(self, robot: str) -> None:
        """Note that a robot neither is at its waiting place nor drives there: it waits only if it asks, where it is.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        known = self.waits.get(robot)
        if known is None or known.wait_at is None:
            return

        def check(stored: Mapping[str, WaitEntry]) -> None:
            if stored.get(robot) != known:
                raise Conflict("it has asked meanwhile")

        try:
            await self.waits.store(robot, known.model_copy(update={"wait_at": None, "arrives_by": None}), check)
        except Conflict:
            await self.waits.read()

    async def _end_wait(self, robot: str) -> None:
        if self.waits.get(robot) is not None:
            await self.waits.store(robot, None, lambda _: None)

    def _charge(self, robot: str) -> float | None:
        battery = self.robots.get(robot).battery
        fresh = battery.age is not None and battery.stale_since is None
        return battery.reading.percentage if fresh else None

    def _refusal(self, ask: Ask, obstacles: Mapping[str, Obstacle], grant: Grant) -> GatewayError:
        """Return why a robot gets none of some docks: if one of them will be free again, that it is occupied."""
        reasons = (Obstacle.QUEUE, Obstacle.OCCUPIED, Obstacle.TOO_MANY, Obstacle.OUT_OF_ORDER, Obstacle.UNFIT)
        dock_id, reason = next((name, why) for why in reasons for name, found in obstacles.items() if found is why)
        record = self.records.get(dock_id) or policy.FREE
        others = f", and no other dock of {ask.robot} is free" if len(ask.docks) > 1 else ""
        if reason is Obstacle.UNFIT:
            return Conflict(f"the dock {dock_id} is not for {ask.robot}", code="dock_not_for_robot")
        if reason is Obstacle.OUT_OF_ORDER:
            note = f": {record.note}" if record.note else ""
            return Conflict(f"the dock {dock_id} is out of order{note}{others}", code="dock_out_of_order")
        if reason is Obstacle.TOO_MANY:
            return DockOccupied(f"{ask.robot} has too many goals to the dock {dock_id} already")
        if reason is Obstacle.QUEUE or record.hold is None:
            return DockOccupied(f"another robot waits for the dock {dock_id}, and comes first{others}")
        hold = record.hold
        shown = hold.robot if hold.robot is not None and grant.covers_robot(hold.robot) else None
        who = shown or ("another robot" if hold.robot is not None else "a robot without a gateway")
        does = "stands on" if hold.standing else "is on its way to"
        return DockOccupied(f"{who} {does} the dock {dock_id}{others}", robot=shown, since_at=hold.since_at)

    # ------------------------------------------------------------------ people

    async def report(
        self,
        dock_id: str,
        revise: Callable[[DockRecord, datetime], DockRecord],
    ) -> None:
        """Store what a person says of a dock.

        Args:
            dock_id: The dock.
            revise: Returns the record with it, or raises.

        Raises:
            NotFound: `shared_dock_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        while True:
            if dock_id not in await self.book.read():
                raise self.missing(dock_id)
            before = (await self.records.read()).get(dock_id, policy.FREE)
            after = revise(before, self._clock())
            if after == before or await self.change(dock_id, before, after):
                return

    def missing(self, dock_id: str) -> NotFound:
        """Return the error that there is no such dock."""
        return NotFound(f"there is no shared dock {dock_id}", code="shared_dock_not_found")


def _describe(record: DockRecord) -> str:
    if record.hold is None:
        return "free"
    who: Any = record.hold.robot or "a robot without a gateway"
    return f"{who} stands there" if record.hold.standing else f"reserved for {who}"
