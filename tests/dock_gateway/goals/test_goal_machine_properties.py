"""Whatever order, loss, doubling and restart of messages: what readers are told of goals is true, and ends once."""

import copy
from collections import Counter
from typing import Any

import orjson
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from dock_gateway.core.event import Event, Now, moment, result_event, status_event
from dock_gateway.core.goal import FROM_ROS, Goal, GoalError, GoalStatus, ResultAnswer
from dock_gateway.goals.goal_machine import (
    AwaitResult,
    GoalChange,
    GoalMachine,
    Notify,
    PublishEnd,
    PublishEvent,
    Store,
)
from dock_gateway.goals.limits import LIMITS
from tests.support.tracking import S

OURS, ELSEWHERE, EXTERNAL = "ours", "sent at another gateway", "another client's"
GOALS = st.sampled_from([OURS, OURS, ELSEWHERE, EXTERNAL])
STATUSES = st.sampled_from(sorted(FROM_ROS.values()))
ENDS = st.sampled_from([S.SUCCEEDED, S.CANCELED, S.ABORTED])
ORDER = [S.PENDING, S.ACCEPTED, S.EXECUTING, S.CANCELING]
WHY, UNWANTED = GoalError("why", "because"), GoalError("stopped", "a stop was requested")


class World(RuleBasedStateMachine):
    """A gateway that is started again and again, its history, its action server, and all that readers were told."""

    def __init__(self) -> None:
        super().__init__()
        self.seconds = 1_000.0
        self.last_stamp = 0
        # A gateway stores its goal before it sends it.
        self.history = {ELSEWHERE: Goal(ELSEWHERE, "/dock", "pkg/action/Dock", moment(0))}
        self.told: dict[str, str] = {}  # the status that readers know, by goal
        self.ends: Counter[str] = Counter()
        self.doubtful: set[str] = set()  # shown as running after their end, as the history could not tell
        self.last_id = ""
        self.start()

    def start(self) -> None:
        self.machine = GoalMachine("/dock", "pkg/action/Dock", self.stamp, self.now)
        self.goals: dict[str, Goal] = {}  # every goal that this process knew
        self.final: dict[str, GoalStatus] = {}
        self.requested: set[str] = set()
        self.adopted: set[str] = set()
        self.adopted_blindly: set[str] = set()

    @property
    def now(self) -> Now:
        self.seconds += 0.001
        return Now(int(self.seconds * 1e9), self.seconds)

    def stamp(self, source_ns: int) -> int:
        self.last_stamp = max(source_ns, self.last_stamp + 1)
        return self.last_stamp

    # ------------------------------------------------------------------ what the machine wants done

    def carry_out(self) -> list[Any]:
        outputs = list(self.machine.outputs)
        self.machine.outputs.clear()
        for output in outputs:
            match output:
                case PublishEvent(event):
                    self.publish(event)
                case Store(goal):
                    self.store(goal)
                case AwaitResult(goal):
                    self.requested.add(goal.goal_id)
                case PublishEnd(goal, source_ns):
                    self.store(goal)
                    self.publish_end(goal, source_ns)
        self.goals.update(self.machine.live)
        self.final |= {goal_id: goal.status for goal_id, goal in self.goals.items() if goal.status.final}
        return outputs

    def publish(self, event: Event, *, end: bool = False) -> None:
        document = orjson.loads(event.data)
        goal_id, before = document["goal_id"], self.told.get(document["goal_id"])
        assert document["id"] > self.last_id, "ids rise"
        self.last_id = document["id"]
        assert end or not self.ends[goal_id] or goal_id in self.doubtful, "nothing is told of a goal after its end"
        if document["type"] == "status":
            status = document["status"]
            if before in ORDER and status in ORDER:
                assert ORDER.index(status) >= ORDER.index(before), "no state goes back"
            known = self.history.get(goal_id)
            if known is not None and goal_id not in self.adopted_blindly:
                assert document["origin"] == known.origin, "a goal of ours is never shown as another client's"
            self.told[goal_id] = status

    def store(self, goal: Goal) -> None:
        stored = self.history.get(goal.goal_id)
        if stored is not None and stored.status.final:
            if goal.goal_id in self.adopted_blindly:
                return  # the history keeps an end that it knows
            assert goal.status is stored.status
            assert stored.result in (None, goal.result), "a result stays"
        self.history[goal.goal_id] = kept = copy.copy(goal)
        if stored is not None and stored.origin == "gateway":
            kept.attribute(stored)

    def publish_end(self, goal: Goal, source_ns: int) -> None:
        stamp = self.stamp(source_ns)
        self.publish(status_event(goal, stamp, source_ns))
        self.ends[goal.goal_id] += 1
        self.publish(result_event(goal, stamp, source_ns), end=True)
        assert self.ends[goal.goal_id] == 1 or goal.goal_id in self.doubtful, "each goal ends once"
        assert goal.status.final
        assert self.history[goal.goal_id].status.final, "an end is stored before it is published"

    # ------------------------------------------------------------------ the action server

    @rule(goal_id=GOALS, status=STATUSES)
    def report(self, goal_id: str, status: GoalStatus) -> None:
        goal = self.machine.live.get(goal_id)
        was_lost = goal is not None and goal.status is S.LOST
        now = self.now
        self.machine.report(now, goal_id, status, 1, now.ns)
        outputs = self.carry_out()
        if goal is None:
            return
        assert goal_id in self.requested, "every result awaited is requested"
        if status.terminal:
            assert AwaitResult(goal, (status, now.ns)) in outputs
        elif was_lost:
            assert (goal.status, goal.error) == (status, self.machine.unwanted.get(goal_id))
            assert Notify(GoalChange.RETURNED, goal) in outputs, "a lost goal that is reported again returns"
        else:
            assert goal.status.final or ORDER.index(goal.status) >= ORDER.index(status)

    @rule(goal_id=GOALS)
    def feedback(self, goal_id: str) -> None:
        goal = self.machine.live.get(goal_id)
        count = goal.feedback_count if goal else 0
        now = self.now
        self.machine.feedback(now, goal_id, b"{}", now.ns)
        self.carry_out()
        if goal is not None:
            assert goal.feedback_count == count + 1
            assert goal.status is not S.LOST, "a lost goal that sends feedback returns"

    @rule(goal_id=GOALS, status=STATUSES | st.none(), result=st.sampled_from([b"{}", None]))
    def answer(self, goal_id: str, status: GoalStatus | None, result: bytes | None) -> None:
        """A result, or none in time; perhaps once more, as it was requested again."""
        if goal_id not in self.requested:
            return
        goal = self.goals[goal_id]
        was_lost = goal.status is S.LOST
        if status is None:
            self.machine.lose(self.now, goal, GoalError("action_server_lost", "unknown"))
        else:
            self.machine.answered(self.now, goal, ResultAnswer(status, result), None)
        self.carry_out()
        if was_lost and status in (S.CANCELED, S.ABORTED):
            assert goal.error == self.machine.unwanted.get(goal_id), "what must not run says why, however it ended"
        assert goal.status.terminal or (status is not None and not status.terminal)

    # ------------------------------------------------------------------ this gateway

    @rule()
    def send(self) -> None:
        goal = self.machine.live.get(OURS)
        if OURS not in self.history and OURS not in self.machine.newcomers:
            goal = Goal(OURS, "/dock", "pkg/action/Dock", moment(self.now.ns))
            self.history[OURS] = copy.copy(goal)
        elif goal is None or goal.status is not S.LOST:
            return
        self.machine.add(self.now, goal)
        self.carry_out()
        assert self.told[OURS] == "pending"

    @rule(accepted=st.booleans())
    def server_decides(self, accepted: bool) -> None:
        goal = self.goals.get(OURS)
        if goal is None or (not accepted and goal.status is not S.PENDING):
            return
        if accepted:
            self.machine.accept(self.now, goal, 1)
        else:
            self.machine.end(self.now, goal, S.REJECTED, error=WHY)
        self.carry_out()
        assert OURS in self.requested if accepted else goal.status is S.REJECTED

    @rule(goal_id=GOALS, wanted=st.booleans())
    def want(self, goal_id: str, wanted: bool) -> None:
        if wanted:
            self.machine.unwanted.pop(goal_id, None)
        else:
            self.machine.unwanted[goal_id] = UNWANTED

    @rule(goal_id=GOALS, what=st.sampled_from(["cancel", "lose", "lose", "stall", "progress"]), flag=st.booleans())
    def change(self, goal_id: str, what: str, flag: bool) -> None:
        """What submission, cancellation and the server watch ask for, perhaps too late."""
        goal = self.goals.get(goal_id)
        if goal is None:
            return
        now, error = self.now, goal.error
        if what == "cancel":
            self.machine.explain(now, goal, WHY)
            assert goal.error == (error if goal.status.terminal else WHY)
            self.machine.move(now, goal, S.CANCELING)
        elif what == "lose":
            self.machine.lose(now, goal, GoalError("action_server_lost", "silent"))
            assert goal.status.terminal
        elif what == "progress":
            self.machine.progress(now, goal, "DRIVING", int(flag), now.ns)
        elif goal_id in self.machine.live:
            self.machine.stall(now, goal, stalled=flag)
            assert goal.stalled is flag
        self.carry_out()

    # ------------------------------------------------------------------ the history and other gateways

    @rule(answers=st.sampled_from([True, True, False]))
    def look_up(self, answers: bool) -> None:
        asked = list(self.machine.newcomers)
        known = {goal_id: copy.copy(self.history[goal_id]) for goal_id in asked if goal_id in self.history}
        self.seconds += 2 * LIMITS.patience
        ready, _ = self.machine.newcomers.ready(asked, known if answers else None, self.seconds)
        assert {*ready} == {*asked} or (not answers and {*ready} < {*asked})
        for goal_id in ready:
            assert goal_id not in self.adopted, "a goal is looked up once"
            self.adopted.add(goal_id)
            if not answers:
                self.adopted_blindly.add(goal_id)
                if goal_id in known and known[goal_id].status.final:
                    self.doubtful.add(goal_id)
            self.machine.adopt(self.now, goal_id, known.get(goal_id) if answers else None)
            self.carry_out()
            assert goal_id in self.requested or self.machine.ended(goal_id), "every result awaited is requested"

    @rule(status=ENDS | st.just(S.EXECUTING))
    def another_gateway(self, status: GoalStatus) -> None:
        """Hears of its goal, and perhaps of its end, first."""
        if ELSEWHERE not in self.machine.live:
            self.history[ELSEWHERE].advance(status, moment(self.now.ns))

    @rule()
    def restart(self) -> None:
        self.seconds += 60.0
        self.start()
        self.take_up([goal for goal in self.history.values() if not goal.status.final])
        assert all(goal_id in self.requested for goal_id in self.machine.live), "every result awaited is requested"

    @rule()
    def history_is_back(self) -> None:
        """Goals that were adopted while it was away turn out to be ours; the others are known."""
        ours = [goal for goal in self.history.values() if not goal.status.final and goal.origin == "gateway"]
        self.take_up([goal for goal in ours if goal.goal_id in self.machine.live])
        assert all(
            self.machine.live[goal.goal_id].origin == "gateway" for goal in ours if goal.goal_id in self.machine.live
        )

    def take_up(self, goals: list[Goal]) -> None:
        for goal in goals:
            self.adopted_blindly.discard(goal.goal_id)
            before = self.machine.live.get(goal.goal_id)
            self.machine.take_up(self.now, copy.copy(goal))
            assert before is None or self.machine.live[goal.goal_id] is before
            self.carry_out()

    # ------------------------------------------------------------------ always

    @invariant()
    def an_ended_goal_stays_as_it_ended(self) -> None:
        for goal_id, status in self.final.items():
            assert self.goals[goal_id].status is status
            assert goal_id not in self.machine.live
            assert self.machine.ended(goal_id)

    @invariant()
    def what_is_known_is_not_looked_up(self) -> None:
        assert not {*self.machine.newcomers} & {*self.machine.live, *self.final}

    @invariant()
    def running_goals_are_those_that_have_not_ended(self) -> None:
        assert {goal.goal_id for goal in self.machine.running()} == {
            goal_id for goal_id, goal in self.goals.items() if not goal.status.terminal
        }

    def teardown(self) -> None:
        """When the server answers at last, each goal has ended once."""
        self.look_up(answers=True)
        for goal in list(self.machine.live.values()):
            self.machine.answered(self.now, goal, ResultAnswer(S.SUCCEEDED, b"{}"), None)
            self.carry_out()
        assert all(self.ends[goal_id] == 1 for goal_id in self.told.keys() - self.doubtful), "each goal ends once"


TestWorld = World.TestCase
TestWorld.settings = settings(max_examples=100, stateful_step_count=40)
