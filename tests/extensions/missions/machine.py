"""A mission, two gateways that follow it, and what happens around it, as a state machine of Hypothesis."""

from dataclasses import dataclass, field
from datetime import timedelta
from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from dock_gateway.core.goal import Goal, GoalError, GoalStatus, Verb
from dock_gateway.extensions.missions import progress, recharge, waiting
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import Cancel, Change, Facts, Send, Sent
from dock_gateway.extensions.missions.progress import begins_message, next_move
from dock_gateway.extensions.missions.step import FailurePolicy
from dock_gateway.extensions.missions.step_entry import Reason, StepStatus
from dock_gateway.extensions.missions.step_kinds import Waypoint
from tests.extensions.missions.examples import CALL, DOCK, FIBONACCI, NOON, PUBLISH, UNDOCK, begun

ENDINGS = st.sampled_from([GoalStatus.SUCCEEDED, GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.CANCELED])
WAITS = [{"wait": {"seconds": 20}}, {"wait": {"battery": 0.5}}, {"wait": {"person": True}}]
STEPS = st.builds(
    lambda kind, tries, timeout, policy: kind | {"tries": tries, "timeout_s": timeout, "on_failure": policy},
    st.sampled_from(
        [
            DOCK,
            UNDOCK,
            FIBONACCI,
            FIBONACCI | {"interruptible": True},
            CALL,
            PUBLISH,
            {"notify": {"text": "Hello"}},
            *WAITS,
        ]
    ),
    st.integers(1, 3),
    st.sampled_from([None, 30, 120]),
    st.sampled_from(["end", "next"]),
)
NESTED = st.one_of(
    STEPS,
    st.lists(STEPS, min_size=1, max_size=2).map(lambda steps: {"repeat": {"steps": steps, "times": 2}}),
    st.lists(STEPS.map(lambda step: step | {"on_failure": "end"}), min_size=1, max_size=2).map(
        lambda steps: {"first_that_works": steps, "on_failure": "next"}
    ),
)


# A break of which the battery is low in half of the examples.
LIMITS = {"below": 0.3, "charge_to": 0.8}
# Where the robot waits for a dock that is occupied.
BAY = Waypoint(x=1.0, y=2.0)
Key = tuple[str, int]  # a place in the mission, and a try


def rounds_of(mission: MissionEntry) -> tuple[int, ...]:
    """Return in which rounds of what is repeated a mission is."""
    around = [step for at, step in enumerate(mission.steps) if at < mission.step <= at + step.size]
    return tuple(step.repeat.round for step in around if step.repeat is not None)


@dataclass
class Server:
    """An action server with a gateway's history of goals: one goal for a key."""

    goals: dict[Key, Goal] = field(default_factory=dict)
    asked_to_cancel: set[str] = field(default_factory=set)

    def send(self, key: Key, verb: Verb | None = None) -> Goal:
        if key not in self.goals:
            self.goals[key] = Goal(f"goal-{len(self.goals)}", "/dock", "pkg/action/T", NOON, verb=verb)
            self.goals[key].status = GoalStatus.EXECUTING
        return self.goals[key]

    def find(self, goal_id: str | None) -> Goal | None:
        return next((goal for goal in self.goals.values() if goal.goal_id == goal_id), None)

    def running(self) -> list[Goal]:
        return [goal for goal in self.goals.values() if not goal.status.final]


class MissionMachine(RuleBasedStateMachine):
    """One mission, two gateways that follow it, and what happens around it."""

    @initialize(steps=st.lists(NESTED, min_size=1, max_size=5), limits=st.sampled_from([None, LIMITS]))
    def begin(self, steps: list[dict[str, Any]], limits: dict[str, float] | None) -> None:
        self.now = NOON
        self.stored = begun(*steps, battery=limits)
        self.copies = [self.stored, self.stored]  # what each gateway has read last
        self.server = Server()
        self.stopped = False
        self.told = [False, False]  # the gateways that have had a stop since they last looked
        self.battery: float | None = 0.2
        self.docked = False
        self.occupied = False  # the dock, by another robot
        self.given_up: set[str] = set()
        self.may_move = True  # not so after a stop until somebody continues
        self.last_ended: MissionEntry | None = None
        self.begun: list[dict[Key, Sent]] = [{}, {}]  # the messages whose tries each gateway has begun
        self.messages: list[Key] = []  # those that were sent
        self.rounds: dict[Key, tuple[int, ...]] = {}  # in which rounds goals were sent, by their keys
        self.flat = not any(step.size for step in self.stored.steps)

    # ------------------------------------------------------------------ the gateways

    def facts(self, gateway: int, mission: MissionEntry) -> Facts:
        step = mission.current
        goal = None
        if step.has_goal:
            key = (mission.position, step.attempt)
            goal = self.server.goals.get(key) if step.goal_id is None else self.server.find(step.goal_id)
        given_up = goal is not None and goal.goal_id in self.given_up
        sent = self.begun[gateway].get((mission.position, step.attempt)) if step.has_message else None
        return Facts(
            stopped=self.told[gateway],
            latched=self.stopped,
            battery=self.battery,
            charging=self.docked,
            discharging=not self.docked,
            docked=self.docked,
            goal=goal,
            given_up=given_up,
            sent=sent,
            gateway=str(gateway),
        )

    def store(self, gateway: int, after: MissionEntry) -> bool:
        """Store a change, unless another one was first."""
        first = self.copies[gateway].revision == self.stored.revision
        if first:
            assert not self.stored.status.ended
            self.stored = after
        self.copies[gateway] = self.stored
        return first

    @rule(gateway=st.integers(0, 1), killed=st.sampled_from([False, False, True]))
    def move(self, gateway: int, killed: bool) -> None:
        mission = self.copies[gateway]
        if mission.status.ended:
            self.copies[gateway] = self.stored
            return
        facts = self.facts(gateway, mission)
        match next_move(mission, facts, self.now):
            case Change(after):
                assert after.revision > mission.revision
                if not killed and self.store(gateway, after) and begins_message(mission, after):
                    self.begun[gateway][after.position, after.current.attempt] = Sent()
                if not killed and after.status is not MissionStatus.RUNNING:
                    self.told[gateway] = False
            case Send() if mission.current.is_message:
                self.send_message(gateway, mission, killed=killed)
            case Send():
                self.send(gateway, mission, killed=killed)
            case Cancel(goal):
                assert goal is facts.goal
                self.server.asked_to_cancel.add(goal.goal_id)
                if goal.status is GoalStatus.LOST:
                    self.given_up.add(goal.goal_id)

    def send_message(self, gateway: int, mission: MissionEntry, *, killed: bool) -> None:
        """Send the message of a step; a gateway that is killed forgets all that it has begun."""
        key = (mission.position, mission.current.attempt)
        if self.stopped:
            self.begun[gateway][key] = Sent(over=True, error=Reason(code="stop_latched", detail=""), by_stop=True)
            return
        assert self.may_move
        self.messages.append(key)
        self.begun[gateway][key] = Sent(over=True)
        if killed:
            self.begun[gateway].clear()

    def send(self, gateway: int, mission: MissionEntry, *, killed: bool) -> None:
        key = (mission.position, mission.current.attempt)
        if key not in self.server.goals:
            assert self.may_move
            assert mission.current.verb == "dock" or not recharge.is_due(mission, self.facts(gateway, mission))
            assert not (mission.parked and mission.current.verb is None)
            if killed and mission.revision != self.stored.revision:
                return  # it is killed before it sends
            if self.occupied and mission.current.verb == "dock":
                after = waiting.drive(mission, BAY, self.facts(gateway, mission), self.now)
                assert after is None or not self.docked
                if after is not None and not killed:
                    self.store(gateway, after)
                return
        goal = self.server.send(key, mission.current.verb)
        self.rounds[key] = rounds_of(mission)
        if not killed:
            self.store(gateway, mission.with_step(goal_id=goal.goal_id))
            if not progress.has_try(self.stored, mission):
                self.server.asked_to_cancel.add(goal.goal_id)

    @rule(gateway=st.integers(0, 1))
    def read(self, gateway: int) -> None:
        self.copies[gateway] = self.stored

    # ------------------------------------------------------------------ the world

    @rule(seconds=st.sampled_from([1, 5, 20, 40, 200]))
    def wait(self, seconds: int) -> None:
        self.now += timedelta(seconds=seconds)

    @rule(level=st.sampled_from([0.1, 0.9, 0.9, None]), docked=st.booleans())
    def charge(self, level: float | None, docked: bool) -> None:
        self.battery, self.docked = level, docked

    @rule(occupied=st.booleans())
    def occupy(self, occupied: bool) -> None:
        self.occupied = occupied

    @precondition(lambda self: self.server.running())
    @rule(data=st.data(), status=ENDINGS)
    def end(self, data: st.DataObject, status: GoalStatus) -> None:
        goal = data.draw(st.sampled_from(self.server.running()))
        goal.status = GoalStatus.CANCELED if goal.goal_id in self.server.asked_to_cancel else status
        if self.stopped:
            goal.status, goal.error = GoalStatus.CANCELED, GoalError("stopped", "a stop was requested")
        if goal.status is GoalStatus.SUCCEEDED:
            self.docked = goal.verb == "dock"

    @precondition(lambda self: self.server.running())
    @rule(data=st.data())
    def lose(self, data: st.DataObject) -> None:
        data.draw(st.sampled_from(self.server.running())).status = GoalStatus.LOST

    @rule()
    def stop(self) -> None:
        """A gateway has the stop at once, before it makes another move."""
        self.stopped, self.may_move = True, False
        for goal in self.server.running():
            goal.status, goal.error = GoalStatus.CANCELED, GoalError("stopped", "a stop was requested")
        self.copies = [self.stored, self.stored]
        if self.stored.status is MissionStatus.RUNNING:
            self.told = [True, True]

    @rule()
    def release(self) -> None:
        if self.stored.status is not MissionStatus.RUNNING:  # the stop has held it, as a latched one does for certain
            self.stopped = False

    # ------------------------------------------------------------------ people

    def revise(self, after: MissionEntry) -> None:
        self.copies[0] = self.stored
        self.store(0, after)

    @precondition(lambda self: self.stored.status is MissionStatus.HELD and not self.stopped)
    @rule(skip=st.sampled_from([False, False, True]))
    def resume(self, skip: bool) -> None:
        self.may_move = True
        self.revise((progress.skip if skip else progress.resume)(self.stored, self.now))

    @precondition(lambda self: self.stored.status is MissionStatus.RUNNING and not self.stored.pausing)
    @rule()
    def pause(self) -> None:
        self.revise(progress.pause(self.stored))

    @precondition(lambda self: self.stored.status in (MissionStatus.RUNNING, MissionStatus.HELD))
    @rule(really=st.integers(0, 5))
    def cancel(self, really: int) -> None:
        if really == 0:
            self.revise(progress.cancel(self.stored, self.now))

    # ------------------------------------------------------------------ what holds

    @invariant()
    def each_step_is_carried_out_once(self) -> None:
        goals = self.server.goals.items()
        done = [
            (key[0], self.rounds[key])
            for key, goal in goals
            if goal.status is GoalStatus.SUCCEEDED and key[0].isdecimal()
        ]
        assert len(done) == len({*done})
        assert len(self.messages) == len({*self.messages})

    @invariant()
    def steps_come_in_order(self) -> None:
        if not self.flat:
            return  # `test_program` has that of the others
        for keys in ([*self.server.goals], self.messages):
            places = [(int(place), attempt) for place, attempt in keys if place.isdecimal()]
            assert places == sorted(places)
        for step in self.stored.steps[: self.stored.step]:
            final = (StepStatus.SUCCEEDED, StepStatus.SKIPPED)
            assert step.status in final or (step.status is StepStatus.FAILED and step.on_failure is FailurePolicy.NEXT)
        assert all(step.attempt == 0 for step in self.stored.steps[self.stored.step + 1 :])

    @invariant()
    def one_goal_runs_at_a_time(self) -> None:
        running = {goal.goal_id for goal in self.server.running()} - self.given_up - self.server.asked_to_cancel
        assert len(running) <= 1

    @invariant()
    def an_ended_mission_stays_as_it_is(self) -> None:
        if self.last_ended is not None:
            assert self.stored == self.last_ended
        if self.stored.status.ended:
            self.last_ended = self.stored
            assert self.stored.held_for is None
            assert self.stored.recharge is None
            assert self.stored.drive is None
            assert self.stored.wait_at is None
            running = {goal.goal_id for goal in self.server.running()}
            assert running <= self.given_up | self.server.asked_to_cancel

    @invariant()
    def a_held_mission_says_why(self) -> None:
        assert (self.stored.status is MissionStatus.HELD) is isinstance(self.stored.held_for, HoldReason)

    def teardown(self) -> None:
        """With nothing in its way, it comes to its end."""
        if not hasattr(self, "stored"):
            return
        self.stopped, self.battery, self.may_move, self.told = False, 1.0, True, [False, False]
        self.occupied = False
        for _ in range(200):
            if self.stored.status.ended:
                break
            self.read(0)
            if self.stored.status is MissionStatus.HELD:
                self.revise(progress.resume(self.stored, self.now))
            for goal in self.server.running():
                goal.status = GoalStatus.SUCCEEDED
            self.move(0, killed=False)
            self.now += timedelta(seconds=10)
        assert self.stored.status.ended
