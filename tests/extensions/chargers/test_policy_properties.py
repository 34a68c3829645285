"""Over all interleavings: no dock has two robots, no reservation is for ever, no robot that waits starves.

A world of robots, docks and two gateways on one database. Each gateway reads and stores in steps of its own, so that
what it decided by may be outdated; goals start, fail, get lost and return; gateways are killed between any two steps.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.extensions.chargers.dock import DockBody, DockRecord, WaitEntry
from dock_gateway.extensions.chargers.policy import (
    FREE,
    SENT_WITHIN,
    Ask,
    GoalState,
    Seen,
    best,
    choices,
    follow,
    is_waiting,
    reserve,
    waits_for,
)

NOON = datetime(2026, 11, 30, 12, tzinfo=UTC)
ROBOTS = ("/r1", "/r2", "/r3", "/r4")
NAMES = ("a", "b")
# Fewer places to wait at than robots.
PLACES = {"a": [{"x": 1.0, "y": 0.0}, {"x": 2.0, "y": 0.0}], "b": [{"x": 2.0, "y": 0.0}]}
DOCKS = {name: DockBody.model_validate({"waiting_places": PLACES[name]}).entry() for name in NAMES}


@dataclass
class Goal:
    robot: str
    dock: str
    state: GoalState = GoalState.MISSING  # until it is stored
    moving: bool = False  # whether its server drives the robot, known or not


@dataclass
class Pending:
    """What a gateway has read, and has not done yet."""

    robot: str
    dock: str
    before: DockRecord
    since: datetime  # it has read, or reserved the dock
    reserved: bool = False
    goal_id: str = ""


@dataclass
class World:
    random: Random
    by_charge: bool = False
    now: datetime = NOON
    records: dict[str, DockRecord] = field(default_factory=dict)
    waits: dict[str, WaitEntry] = field(default_factory=dict)
    goals: dict[str, Goal] = field(default_factory=dict)
    on: dict[str, str] = field(default_factory=dict)  # the dock on which a robot stands
    dead: set[str] = field(default_factory=set)
    asking: list[Pending] = field(default_factory=list)
    followed: list[tuple[str, DockRecord, DockRecord]] = field(default_factory=list)

    # ------------------------------------------------------------------ gateways

    def ask(self, robot: str, *, waits: bool = True) -> None:
        """A gateway reads, and chooses; what comes of it is stored later."""
        if robot in self.dead or robot in self.on:
            return
        docks = self.random.choice([NAMES, NAMES[::-1], NAMES[:1]])
        ask = Ask(robot, docks)
        free, _ = choices(ask, DOCKS, self.records, self.waits, self.now, by_charge=self.by_charge)
        if free:
            distances = {name: self.random.random() for name in free if self.random.random() < 0.5}
            chosen = best(ask, free, self.records, distances)
            self.asking.append(Pending(robot, chosen, self.records.get(chosen, FREE), self.now))
        elif waits:
            entry = waits_for(ask, DOCKS, self.waits, self.now)
            self.waits[robot] = entry.model_copy(update={"battery": self.random.random()})

    def store(self) -> None:
        """A gateway stores what it has chosen, and then its goal."""
        if not self.asking:
            return
        pending = self.asking[self.random.randrange(len(self.asking))]
        if not pending.reserved:
            if self.records.get(pending.dock, FREE) != pending.before:
                self.asking.remove(pending)
                return
            pending.goal_id, pending.reserved, pending.since = f"g{len(self.goals)}", True, self.now
            self.goals[pending.goal_id] = Goal(pending.robot, pending.dock)
            self.records[pending.dock] = reserve(pending.before, pending.robot, pending.goal_id, self.now)
            self.waits.pop(pending.robot, None)
            return
        self.asking.remove(pending)
        goal = self.goals[pending.goal_id]
        busy = self.running(pending.robot) or pending.robot in self.on or pending.robot in self.dead
        goal.state, goal.moving = (GoalState.ENDED, False) if busy else (GoalState.RUNS, True)

    def kill(self) -> None:
        """A gateway ends between two of its steps."""
        if self.asking:
            self.asking.pop(self.random.randrange(len(self.asking)))

    def look(self, dock: str) -> None:
        """A gateway decides what it has seen means; it may store that later."""
        record = self.records.get(dock)
        if record is not None and record.hold is not None:
            self.followed.append((dock, record, follow(record, self.seen(dock, record), self.now, failures=0)))

    def conclude(self) -> None:
        if self.followed:
            dock, before, after = self.followed.pop(self.random.randrange(len(self.followed)))
            if self.records.get(dock) == before:
                self.records[dock] = after

    def seen(self, dock: str, record: DockRecord) -> Seen:
        assert record.hold is not None
        robot = record.hold.robot or ""
        others = [
            each.hold
            for name, each in self.records.items()
            if name != dock and each.hold is not None and each.hold.robot == robot and each.hold.standing
        ]
        silent = robot in self.dead
        return Seen(
            {goal_id: self.goals[goal_id].state for goal_id in record.hold.goal_ids},
            docked=not silent and robot in self.on and not others,
            away=not silent and robot not in self.on and not self.running(robot),
            elsewhere=any(other.since_at > record.hold.since_at for other in others),
        )

    # ------------------------------------------------------------------ robots

    def running(self, robot: str) -> list[Goal]:
        return [goal for goal in self.goals.values() if goal.robot == robot and goal.moving]

    def end(self, robot: str) -> None:
        """A goal ends, or contact with it is lost, or it returns."""
        for goal in self.running(robot):
            if goal.state is GoalState.LOST:
                goal.state = GoalState.RUNS
                continue
            goal.state = self.random.choice(
                [GoalState.SUCCEEDED, GoalState.SUCCEEDED, GoalState.ABORTED, GoalState.ENDED, GoalState.LOST]
            )
            goal.moving = goal.state is GoalState.LOST
            if goal.state is GoalState.SUCCEEDED:
                self.on[robot] = goal.dock

    def undock(self, robot: str) -> None:
        if robot not in self.dead:
            self.on.pop(robot, None)

    def die(self, robot: str) -> None:
        """A robot is switched off where it is; its goals are lost."""
        self.dead.add(robot)
        for goal in self.running(robot):
            goal.state = GoalState.LOST

    def wait(self, seconds: int) -> None:
        """What a gateway has begun to store is stored within a minute, or its gateway has ended."""
        self.now += timedelta(seconds=seconds)
        self.asking = [pending for pending in self.asking if self.now - pending.since < SENT_WITHIN]

    def settle(self) -> None:
        """All gateways and goals come to their end, but for those of robots that died."""
        self.asking.clear()
        self.followed.clear()
        for goal in self.goals.values():
            if goal.state is not GoalState.MISSING and goal.robot not in self.dead:
                goal.state, goal.moving = GoalState.ENDED, False

    def look_at_all(self) -> None:
        for dock in NAMES:
            self.look(dock)
            self.conclude()

    def round(self, patient: str) -> None:
        """Each robot asks, the others always before one of them; goals arrive, and some of the others leave."""
        for robot in (*self.random.sample(ROBOTS[1:], len(ROBOTS) - 1), patient):
            self.ask(robot)
            while self.asking:
                self.store()
        for robot in ROBOTS:
            for goal in self.running(robot):
                goal.state, goal.moving = GoalState.SUCCEEDED, False
                self.on[robot] = goal.dock
            if robot != patient and self.random.random() < 0.3:
                self.undock(robot)
        self.look_at_all()
        self.check()

    def check(self) -> None:
        """At each dock there is one robot at most, on it or on its way, and at each place where robots wait."""
        places = [wait.wait_at for wait in self.waits.values() if wait.wait_at and is_waiting(wait, self.now)]
        assert all(places.count(place) == 1 for place in places)
        at: dict[str, set[str]] = {name: set() for name in NAMES}
        for robot, dock in self.on.items():
            at[dock].add(robot)
        for goal in self.goals.values():
            if goal.moving:
                at[goal.dock].add(goal.robot)
        assert all(len(robots) <= 1 for robots in at.values()), at
        for dock, robots in at.items():
            for robot in robots:
                hold = self.records[dock].hold
                assert hold is not None
                assert hold.robot == robot

    def step(self, kind: str, number: int) -> None:
        robot, dock = ROBOTS[number % len(ROBOTS)], NAMES[number % len(NAMES)]
        steps: dict[str, Callable[[], None]] = {
            "ask": lambda: self.ask(robot, waits=number % 3 > 0),
            "store": self.store,
            "kill": self.kill,
            "look": lambda: self.look(dock),
            "conclude": self.conclude,
            "end": lambda: self.end(robot),
            "undock": lambda: self.undock(robot),
            "die": lambda: self.die(robot),
            "later": lambda: self.wait(number),
        }
        steps[kind]()
        self.check()


KINDS = st.sampled_from(
    [*(4 * ["ask"]), *(6 * ["store"]), "kill", *(4 * ["look"]), *(4 * ["conclude"]), *(3 * ["end"]), "undock", "later"]
)
STEPS = st.lists(st.tuples(KINDS | st.just("die"), st.integers(0, 70)), min_size=10, max_size=120)


@settings(max_examples=400)
@given(STEPS, st.integers(0, 2**32), st.booleans())
def test_no_dock_ever_has_two_robots(steps: list[tuple[str, int]], seed: int, by_charge: bool) -> None:
    world = World(Random(seed), by_charge)
    for kind, number in steps:
        world.step(kind, number)


@settings(max_examples=200)
@given(STEPS, st.integers(0, 2**32))
def test_no_reservation_is_for_ever(steps: list[tuple[str, int]], seed: int) -> None:
    """Once all goals have ended and all robots that live have left, only those that died keep a dock."""
    world = World(Random(seed))
    for kind, number in steps:
        world.step(kind, number)
    world.settle()
    for robot in ROBOTS:
        world.undock(robot)
    for _ in range(3):
        world.now += SENT_WITHIN
        world.look_at_all()
    for record in world.records.values():
        assert record.hold is None or record.hold.robot in world.dead


@settings(max_examples=200)
@given(STEPS, st.integers(0, 2**32), st.booleans())
def test_no_robot_that_waits_starves(steps: list[tuple[str, int]], seed: int, by_charge: bool) -> None:
    """As long as robots leave their docks again, each that keeps asking gets one, whatever the others do."""
    world = World(Random(seed), by_charge)
    for kind, number in steps:
        if kind != "die":
            world.step(kind, number)
    patient = ROBOTS[0]
    world.settle()
    world.undock(patient)
    for _ in range(2000):
        if patient in world.on:
            return
        world.now += timedelta(seconds=7)
        world.round(patient)
    pytest.fail(f"{patient} has waited for ever")
