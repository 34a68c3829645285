"""What holds of queues whatever happens: two gateways that begin missions at the same time, stops, moves and robots."""

from dataclasses import replace
from datetime import timedelta

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from dock_gateway.core.errors import Conflict
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.turns import (
    RobotFacts,
    find_turns,
    in_turn,
    last_order,
    next_order,
    place,
    require_turn,
)
from tests.extensions.missions.examples import DOCK, NOON, queued

ROBOTS = ("/a", "/b", "/c")
GROUPS = {"/a": ("pickers",), "/b": ("pickers", "sweepers"), "/c": ("sweepers",)}
ROBOT = st.sampled_from(ROBOTS)


def members(group: str) -> list[str]:
    """Return the robots of a group."""
    return [robot for robot in ROBOTS if group in GROUPS[robot]]


class QueueMachine(RuleBasedStateMachine):
    """Three robots in two groups, and two gateways that may know of the missions what was so a while ago."""

    @initialize()
    def begin(self) -> None:
        self.now = NOON
        self.stored: dict[str, MissionEntry] = {}
        self.copies: list[dict[str, MissionEntry]] = [{}, {}]
        self.robots = {robot: RobotFacts(GROUPS[robot], free=True, charge=0.5) for robot in ROBOTS}
        self.begun: dict[str, str] = {}  # the robots that have begun missions
        self.ended: set[str] = set()
        self.added = 0

    # ------------------------------------------------------------------ people

    @rule(
        whose=ROBOT | st.sampled_from(["pickers", "sweepers", "nobody"]), priority=st.sampled_from([50, 50, 50, 20, 90])
    )
    def add(self, whose: str, priority: int) -> None:
        robot, group = (whose, None) if whose in ROBOTS else (None, whose)
        self.added += 1
        order = next_order(last_order(self.stored), self.now)
        fields = {"order": order, "created_at": self.now, "priority": priority, "group": group}
        self.stored[f"{self.added:03}"] = queued(DOCK, robot=robot).model_copy(update=fields)
        self.pass_time()

    @rule(data=st.data(), before=st.booleans())
    def move(self, data: st.DataObject, before: bool) -> None:
        queue = [key for key, _ in in_turn(self.stored)]
        if len(queue) < 2:
            return
        moved, other = (data.draw(st.sampled_from(queue)) for _ in range(2))
        try:
            changes = place(self.stored, moved, other, members, before=before)
        except Conflict:
            return
        self.stored.update(changes)
        line = [key for key, _ in in_turn(self.stored)]
        assert moved == other or line.index(moved) == line.index(other) + (-1 if before else 1)

    @rule(data=st.data())
    def pause_or_continue(self, data: st.DataObject) -> None:
        queue = in_turn(self.stored)
        if queue:
            key, mission = data.draw(st.sampled_from(queue))
            held = mission.status is MissionStatus.HELD
            self.stored[key] = progress.resume(mission, self.now) if held else progress.pause(mission)

    # ------------------------------------------------------------------ robots

    @rule(robot=ROBOT, charge=st.sampled_from([0.2, 0.5, 0.8]), free=st.booleans())
    def change(self, robot: str, charge: float, free: bool) -> None:
        self.robots[robot] = replace(self.robots[robot], charge=charge, free=free)

    @rule(robot=ROBOT)
    def stop_and_release(self, robot: str) -> None:
        self.pass_time()
        self.robots[robot] = replace(self.robots[robot], stopped_at=self.now)

    @rule(robot=ROBOT)
    def end(self, robot: str) -> None:
        for key, mission in self.stored.items():
            if mission.active and mission.robot == robot:
                self.stored[key] = progress.succeed(mission, self.now)
                self.ended.add(key)

    def pass_time(self) -> None:
        self.now += timedelta(seconds=1)

    # ------------------------------------------------------------------ gateways

    @rule(gateway=st.integers(0, 1))
    def read(self, gateway: int) -> None:
        self.copies[gateway] = dict(self.stored)

    @rule(gateway=st.integers(0, 1), killed_after=st.integers(0, 4))
    def look(self, gateway: int, killed_after: int) -> None:
        copy = self.copies[gateway]
        known = {key: mission for key, mission in copy.items() if not mission.status.ended}
        turns = find_turns(known, self.robots)
        assert turns.on.keys() | {known[key].robot for key in turns.waits} <= {*ROBOTS, None}
        assert {*turns.on.values()} | turns.waits.keys() == known.keys()
        for robot, key in [*turns.on.items()][:killed_after]:
            if known[key].in_queue:
                self.begin_mission(gateway, key, robot)

    def begin_mission(self, gateway: int, key: str, robot: str) -> None:
        """Begin a mission as `MissionBook.change` does: if nobody else has changed it, and it is its turn."""
        before, stored = self.copies[gateway][key], self.stored[key]
        if stored.revision != before.revision or stored.status.ended:
            return
        try:
            require_turn(self.stored, key, robot)
        except Conflict:
            return
        facts = self.robots[robot]
        if before.robot is None:
            assert facts.free
            assert before.group in facts.groups
            assert facts.stopped_at is None or facts.stopped_at < before.allowed_since
        else:
            assert before.robot == robot
        queue = [each for each, _ in in_turn(self.stored)]
        for earlier in queue[: queue.index(key)]:  # those of its robot that could begin have begun
            assert self.stored[earlier].robot != robot or self.stored[earlier].status is MissionStatus.HELD
        assert key not in self.begun
        self.begun[key] = robot
        self.stored[key] = self.copies[gateway][key] = progress.start(before, self.now, robot)

    @rule(gateway=st.integers(0, 1))
    def look_at_what_is_so(self, gateway: int) -> None:
        """A gateway that knows all passes no mission over for a later one of the same robot."""
        self.read(gateway)
        known = {key: mission for key, mission in self.stored.items() if not mission.status.ended}
        turns = find_turns(known, self.robots)
        queue = [key for key, _ in in_turn(known)]
        for robot, key in turns.on.items():
            if not known[key].in_queue:
                continue
            facts = self.robots[robot]
            for earlier in queue[: queue.index(key)]:
                each = known[earlier]
                if earlier in turns.waits and each.robot is None and each.status is MissionStatus.QUEUED:
                    able = facts.free and each.group in facts.groups
                    assert not able or (facts.stopped_at is not None and facts.stopped_at >= each.allowed_since)
        for key in turns.waits:
            each = known[key]
            if each.robot is None and each.status is MissionStatus.QUEUED:
                charges = {name: self.robots[name].charge for name in members(each.group or "")}
                assert turns.waits[key] == "group" if not charges else turns.waits[key] in ("robot", "continue")
        self.look(gateway, 4)

    # ------------------------------------------------------------------ what holds

    @invariant()
    def a_robot_is_on_one_mission(self) -> None:
        on = [mission.robot for mission in getattr(self, "stored", {}).values() if mission.active]
        assert len(on) == len({*on})

    @invariant()
    def a_mission_keeps_its_robot(self) -> None:
        for key, robot in getattr(self, "begun", {}).items():
            assert self.stored[key].robot == robot

    def teardown(self) -> None:
        """With nothing in its way, each mission has its turn."""
        if not hasattr(self, "stored"):
            return
        self.robots = {name: replace(each, free=True) for name, each in self.robots.items()}
        self.pass_time()
        for key, mission in in_turn(self.stored):
            let = mission.but(allowed_at=self.now)
            self.stored[key] = progress.resume(let, self.now)
        for _ in range(len(self.stored) + 1):
            self.look_at_what_is_so(0)
            for robot in ROBOTS:
                self.end(robot)
        assert all(mission.status.ended or mission.group == "nobody" for mission in self.stored.values())


QueueMachine.TestCase.settings = settings(max_examples=100, stateful_step_count=40, deadline=None)
TestQueues = QueueMachine.TestCase
