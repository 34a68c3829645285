"""Who moves a robot: a person, an agent, a rule of automatic docking, a mission and its break, in any order."""

from datetime import timedelta
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule

from dock_gateway.core.goal import Goal, GoalStatus, Verb
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.battery import BatteryLimits
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import Facts
from tests.extensions.missions.examples import NOON
from tests.extensions.missions.machine import ENDINGS, LIMITS, NESTED, MissionMachine

pytest.importorskip("dock_gateway.extensions.automation")

from dock_gateway.extensions.automation.policy import DockingPolicy, RobotFacts
from tests.extensions.automation.examples import LOW_BATTERY, Site, changed

AT_WORK = (MissionStatus.RUNNING, MissionStatus.CANCELING)
# Of each goal that drives the robot, and for each 10 s on the dock.
COST, CHARGE = 0.1, 0.2


class OneRobot(MissionMachine):
    """A robot with a mission, a rule that docks it below 20 %, people and agents who send goals, and two gateways."""

    @initialize(steps=st.lists(NESTED, min_size=1, max_size=5), limits=st.sampled_from([None, LIMITS]))
    def begin(self, steps: list[dict[str, Any]], limits: dict[str, float] | None) -> None:
        super().begin(steps, limits)
        # It is there for missions of a rule's robot: the idle time of a rule has tests of its own.
        self.rules = Site(low=changed(LOW_BATTERY, changed_at=NOON - timedelta(days=1)))
        self.others: list[Goal] = []  # of people and agents
        self.of_rule: list[Goal] = []
        self.rule_held = False

    def facts(self, gateway: int, mission: MissionEntry) -> Facts:
        facts = super().facts(gateway, mission)
        fields = {name: getattr(facts, name) for name in Facts.__dataclass_fields__}
        return Facts(**fields | {"other_goal": bool(self.foreign())})

    def foreign(self) -> list[Goal]:
        """The running goals that are not the mission's."""
        return [goal for goal in (*self.others, *self.of_rule) if not goal.status.final]

    # ------------------------------------------------------------------ who else wants the robot

    @precondition(lambda self: not self.stopped)
    @rule(verb=st.sampled_from(["dock", "undock", None]))
    def somebody_sends_a_goal(self, verb: Verb | None) -> None:
        """A person, or an agent whose goal a person has allowed: it runs at once."""
        goal = Goal(f"other-{len(self.others)}", "/dock", "pkg/action/T", self.now, verb=verb)
        goal.status = GoalStatus.EXECUTING
        self.others.append(goal)

    @precondition(lambda self: self.foreign())
    @rule(data=st.data(), status=ENDINGS)
    def another_goal_ends(self, data: st.DataObject, status: GoalStatus) -> None:
        goal = data.draw(st.sampled_from(self.foreign()))
        goal.status = status
        if status is GoalStatus.SUCCEEDED:
            self.docked = goal.verb == "dock"
            self.rule_held &= goal not in self.others

    @rule()
    def the_rule_looks(self) -> None:
        running = [*self.server.running(), *self.foreign()]
        seconds = (self.now - NOON).total_seconds()
        robot = RobotFacts(
            "/",
            fresh=self.battery is not None,
            battery=self.battery,
            docked=self.docked,
            goal_running=any(goal.status is not GoalStatus.LOST for goal in running),
            goal_lost=any(goal.status is GoalStatus.LOST for goal in running),
            at_work=self.stored.status in AT_WORK,
            stopped="stopped" if self.stopped else None,
            held=self.rule_held,
            still_since=seconds - 1000,
        )
        decisions = self.rules.decide(seconds, robot)
        for below in self.rules.verdict.asked.values():
            if self.stored.status is MissionStatus.RUNNING and self.stored.limits is None:
                self.revise(self.stored.but(asked_battery=BatteryLimits(below=below, charge_to=0.8)))
        for decision in decisions:
            if decision.outcome.value == "sent":
                assert not self.rule_held
                assert not self.stopped
                assert self.stored.status not in AT_WORK
                goal = Goal(f"rule-{len(self.of_rule)}", "/dock", "pkg/action/T", self.now, verb="dock")
                goal.status = GoalStatus.EXECUTING
                self.of_rule.append(goal)

    @rule()
    def stop(self) -> None:
        super().stop()
        self.rule_held = True
        for goal in self.foreign():
            goal.status = GoalStatus.CANCELED

    @precondition(lambda self: not self.stopped)
    @rule()
    def somebody_lets_the_rules_go_on(self) -> None:
        self.rule_held = False

    @rule(level=st.sampled_from([0.02, 0.1, 0.19]))
    def the_battery_falls(self, level: float) -> None:
        self.battery, self.docked = level, False

    @rule(gateway=st.integers(0, 1))
    def a_gateway_is_restarted(self, gateway: int) -> None:
        self.copies[gateway] = self.stored
        self.begun[gateway].clear()
        self.told[gateway] = False
        self.rules.policy = DockingPolicy()

    # ------------------------------------------------------------------ what holds

    @invariant()
    def one_goal_of_ours_runs_at_a_time(self) -> None:
        unwanted = self.given_up | self.server.asked_to_cancel
        ours = [goal for goal in self.server.running() if goal.goal_id not in unwanted]
        ours += [goal for goal in self.of_rule if not goal.status.final]
        assert len(ours) <= 1

    def teardown(self) -> None:
        """With nothing in its way, the mission comes to its end, and the robot to its dock before it is empty."""
        if not hasattr(self, "stored") or not hasattr(self, "rules"):
            return
        self.stopped, self.occupied, self.may_move, self.told = False, False, True, [False, False]
        for goal in (*self.server.running(), *self.foreign()):
            goal.status = GoalStatus.SUCCEEDED
        self.battery, self.docked = 0.25, False
        breaks = self.stored.recharges
        drives = 0
        for _ in range(600):
            if self.stored.status.ended:
                break
            self.read(0)
            if self.stored.status is MissionStatus.HELD:
                self.revise(progress.resume(self.stored, self.now))
            for goal in (*self.server.running(), *self.foreign()):
                goal.status = GoalStatus.SUCCEEDED
                self.docked = goal.verb == "dock"
                if goal.verb is None:
                    self.battery -= COST
                    drives += 1
            wait = None if self.stored.status.ended else self.stored.current.wait
            if wait is not None and wait.battery is not None:
                self.docked = True  # a mission that waits for a charge has docked its robot, or a person does
            if self.docked:
                self.battery = min(1.0, self.battery + CHARGE)
            assert self.battery > 0.05
            self.the_rule_looks()
            self.move(0, killed=False)
            self.now += timedelta(seconds=10)
        assert self.stored.status.ended
        assert self.stored.recharges - breaks <= 2 * drives + 2


OneRobot.TestCase.settings = settings(max_examples=150, stateful_step_count=40, deadline=None)
TestOneRobot = OneRobot.TestCase
