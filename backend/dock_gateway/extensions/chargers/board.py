"""The shared docks as people see them: documents and events, within their grants."""

from collections import Counter
from collections.abc import Collection, Mapping
from typing import Any

from dock_gateway.core.errors import DockOccupied, not_covered
from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.chargers import policy
from dock_gateway.extensions.chargers.dock import DockEntry, DockRecord
from dock_gateway.extensions.chargers.schema import DockReport, DockState
from dock_gateway.extensions.chargers.shared_docks import SharedDocks
from dock_gateway.extensions.chargers.watch import DockWatch
from dock_gateway.fleet.fleet import Fleet

Document = dict[str, Any]


class DockBoard:
    """Shows the shared docks, and takes what people say of them.

    Args:
        docks: The docks.
        watch: Follows who has them.
        fleet: The robots and their groups.
        fanout: Receives an event for each change.
    """

    def __init__(self, docks: SharedDocks, watch: DockWatch, fleet: Fleet, fanout: Fanout) -> None:
        self.docks = docks
        self._watch = watch
        self._fleet = fleet
        self._fanout = fanout
        self._published: dict[str, bytes] | None = None

    # ------------------------------------------------------------------ documents

    async def documents(self, grant: Grant) -> list[Document]:
        """Return the docks that fit a robot of a grant, as `GET /shared-docks` shows them, by name.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        await self._read()
        grant, groups = grant.own, self._groups()
        found = sorted(self.docks.book.all().items())
        return [self._narrowed(name, dock, grant, groups) for name, dock in found if _is_for(dock, grant, groups)]

    async def document(self, dock_id: str, grant: Grant) -> Document:
        """Return a dock as `GET /shared-docks/{dock_id}` shows it.

        Raises:
            NotFound: There is none, or it fits no robot of the grant (`shared_dock_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        await self._read()
        grant, dock, groups = grant.own, self.docks.book.get(dock_id), self._groups()
        if dock is None or not _is_for(dock, grant, groups):
            raise self.docks.missing(dock_id)
        return self._narrowed(dock_id, dock, grant, groups)

    async def _read(self) -> None:
        await self.docks.book.read()
        await self.docks.records.read()
        await self.docks.waits.read()

    def _groups(self) -> Mapping[str, tuple[str, ...]]:
        return {state.name: tuple(state.label.groups) for state in self._fleet.states()}

    def _document(self, dock_id: str, dock: DockEntry) -> Document:
        record = self.docks.records.get(dock_id) or policy.FREE
        hold, now = record.hold, utc_now()
        state = state_of(record, silent=dock_id in self._watch.trouble.silent)
        waits = {name: wait for name, wait in self.docks.waits.all().items() if policy.is_waiting(wait, now)}
        waiting = policy.in_order(waits, now, by_charge=self.docks.by_charge)
        return {
            "dock_id": dock_id,
            "etag": self.docks.book.etag(dock),
            **dock.model_dump(),
            "state": state.value,
            "detail": sentence(record, state),
            "robot": None if hold is None else hold.robot,
            "since_at": None if hold is None else hold.since_at,
            "goal_ids": [] if hold is None else [*hold.goal_ids],
            "out_of_order_at": record.out_of_order_at,
            "note": record.note,
            "failures": record.failures,
            "waiting": [
                waits[name].model_dump(include={"since_at", "battery", "wait_at"}) | {"robot": name}
                for name in waiting
                if dock_id in waits[name].docks
            ],
        }

    def _narrowed(self, dock_id: str, dock: DockEntry, grant: Grant, groups: Mapping[str, tuple[str, ...]]) -> Document:
        chosen = {
            "names": tuple(filter(grant.covers_robot, dock.robots.names)),
            "groups": tuple(
                group
                for group in dock.robots.groups
                if not grant.limited or any(group in groups[robot] for robot in groups if grant.covers_robot(robot))
            ),
        }
        narrowed = narrow_document(self._document(dock_id, dock), grant)
        return {**narrowed, "robots": {**narrowed["robots"], **chosen}}

    def counts(self) -> tuple[Counter[str], int]:
        """Return the number of docks in each state, and of robots that wait."""
        records, now = self.docks.records.all(), utc_now()
        silent = self._watch.trouble.silent
        states = Counter(dict.fromkeys((state.value for state in DockState), 0))
        states.update(
            state_of(records.get(name, policy.FREE), silent=name in silent).value for name in self.docks.book.all()
        )
        return states, sum(policy.is_waiting(wait, now) for wait in self.docks.waits.all().values())

    # ------------------------------------------------------------------ what people do

    async def replace(
        self, dock_id: str, dock: DockEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[Document, bool]:
        """Store a dock, new or changed; return it, and whether it is new.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the dock is what it was.
        """
        new = await self.docks.replace(dock_id, dock, condition)
        self._watch.wake()
        return self._document(dock_id, dock), new

    async def remove(self, dock_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a dock.

        Raises:
            ChangedMeanwhile, NotFound, Unavailable: As `SharedDocks.remove`.
        """
        await self.docks.remove(dock_id, condition)
        self._watch.wake()

    async def report(self, dock_id: str, said: DockReport, grant: Grant) -> Document:
        """Store what a person has seen at a dock; return the dock.

        Raises:
            DockOccupied: Nobody stands there, but a goal drives a robot there.
            NotAllowed: The grant does not cover the robot that has the dock, or that is named (`not_allowed`).
            NotFound: `shared_dock_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        await self.document(dock_id, grant)
        grant = grant.own
        running = {goal.goal_id for goal in self.docks.actions.running()}

        def revise(record: DockRecord, now: Any) -> DockRecord:
            holder = None if record.hold is None else record.hold.robot
            if holder is not None and not grant.covers_robot(holder):
                raise not_covered("the robot that has the dock")
            if said.out_of_order is not None:
                changed: dict[str, object] = {"out_of_order_at": record.out_of_order_at or now, "note": said.note}
                if not said.out_of_order:
                    changed = {"out_of_order_at": None, "note": None, "failures": 0}
                record = record.model_copy(update=changed)
            return _occupied(record, said, grant, running, now)

        await self.docks.report(dock_id, revise)
        self._watch.wake()
        return await self.document(dock_id, grant)

    # ------------------------------------------------------------------ events

    def publish(self) -> None:
        """Publish the docks that have changed since the last time."""
        now = {name: encode(self._document(name, dock)) for name, dock in self.docks.book.all().items()}
        if self._published is not None:
            for name in sorted(now.keys() | self._published.keys()):
                if now.get(name) != self._published.get(name):
                    dock = self.docks.book.get(name)
                    document = None if dock is None else self._document(name, dock)
                    event = fleet_event("shared_dock", utc_now(), self._narrow, dock_id=name, shared_dock=document)
                    self._fanout.publish(event)
        self._published = now

    def _narrow(self, document: Document, grant: Grant) -> Document | None:
        grant, dock = grant.own, self.docks.book.get(document["dock_id"])
        if dock is None:
            return None if grant.limited else document
        groups = self._groups()
        if not _is_for(dock, grant, groups):
            return None
        return {**document, "shared_dock": self._narrowed(document["dock_id"], dock, grant, groups)}


def state_of(record: DockRecord, *, silent: bool = False) -> DockState:
    """Return the state of a dock."""
    if record.out_of_order_at is not None:
        return DockState.OUT_OF_ORDER
    if record.hold is None:
        return DockState.FREE
    if record.hold.robot is None:
        return DockState.OCCUPIED_BY_UNKNOWN
    if silent:
        return DockState.NO_CONTACT
    return DockState.OCCUPIED if record.hold.standing else DockState.RESERVED


def sentence(record: DockRecord, state: DockState, robot: str = "") -> str:
    """Return what a state means."""
    who = robot or (record.hold.robot if record.hold is not None and record.hold.robot else "Another robot")
    by = f", {record.hold.by} says" if record.hold is not None and record.hold.by else ""
    match state:
        case DockState.FREE:
            return "Nobody has the dock."
        case DockState.RESERVED:
            return f"{who} is on its way."
        case DockState.OCCUPIED:
            return f"{who} stands on the dock{by}."
        case DockState.OCCUPIED_BY_UNKNOWN:
            return f"A robot without a gateway stands on the dock{by}. Say so when it has left."
        case DockState.NO_CONTACT:
            return f"{who} has the dock, and is not heard. Look where it is."
        case DockState.OUT_OF_ORDER:
            return f"The dock is out of order: {record.note}." if record.note else "The dock is out of order."


def narrow_document(document: Document, grant: Grant) -> Document:
    """Return a dock without the robots beyond a grant."""
    waiting = [each for each in document["waiting"] if grant.covers_robot(each["robot"])]
    robot = document["robot"]
    if robot is None or grant.covers_robot(robot):
        return {**document, "waiting": waiting}
    detail = document["detail"].replace(robot, "Another robot")
    return {**document, "waiting": waiting, "robot": None, "goal_ids": [], "detail": detail}


def _is_for(dock: DockEntry, grant: Grant, groups: Mapping[str, tuple[str, ...]]) -> bool:
    """Return whether a dock fits a robot of a grant."""
    if not grant.limited or any(map(grant.covers_robot, dock.robots.names)):
        return True
    return any(dock.robots.covers(robot, groups[robot]) for robot in groups if grant.covers_robot(robot))


def _occupied(record: DockRecord, said: DockReport, grant: Grant, running: Collection[str], now: Any) -> DockRecord:
    match said.occupied_by:
        case None:
            return record
        case "nobody":
            if (after := policy.left(record, running, now)) is None:
                hold = record.hold
                robot = "a robot" if hold is None or hold.robot is None else hold.robot
                raise DockOccupied(f"a goal drives {robot} to the dock: cancel it first")
            return after
        case "unknown":
            return policy.stand(record, None, said.by, now)
        case robot:
            if not grant.covers_robot(robot):
                raise not_covered(robot)
            return policy.stand(record, robot, said.by, now)
