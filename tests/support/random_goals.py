"""Goals with a robot on which everything comes and goes: battery, odometry, the way, the dock, what the plan does."""

import math
from collections.abc import Callable
from dataclasses import replace
from random import Random

from docking.core.battery import BatteryReading
from docking.core.errors import FailedToCharge, FailedToControl, LostMarker, PushedOff, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, MarkerDetection, Observation, Odometry, Velocity
from docking.goal.behavior import Behavior, Done, Failed, Step
from docking.goal.detector import Detector
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.navigation import CannotNavigate, Navigation, Ride, RideState
from docking.goal.obstacle_watch import ObstacleWatch
from docking.goal.outcome import Outcome
from docking.goal.plan import KnownPoses, Plan
from docking.goal.undock import Undocking
from docking.parameters import (
    ChargingSettings,
    ChargingSource,
    CollisionSettings,
    ControllerName,
    DockSettings,
    DockTimeouts,
    MotionLimits,
    NavigationSettings,
    RecoverySettings,
    SearchSettings,
    UndockTimeouts,
)
from docking.parameters.collision import Outline
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan

PAUSES = (0.1, 0.2, 0.5)
"""Seconds between two steps of a goal; one of them at a time."""
LATE = 60
"""How many steps a goal may take longer: each limit is looked at after the step that exceeds it."""
ERRORS = (FailedToCharge, FailedToControl, LostMarker, PushedOff)


class Comes:
    """Something that comes and goes: for some seconds it is there, then for some it is not."""

    def __init__(self, random: Random, limit: float) -> None:
        """Choose how it comes and goes; half of all things always stay.

        Args:
            random: Where that is drawn from.
            limit: The absence that is too long, in s: most are a little shorter.
        """
        self._random = random
        self._stays = random.random() < 0.5
        self._there_for = random.choice((0.05, 0.3, 1.0, 3.0))
        self._gone_for = limit * random.choice((0.1, 0.5, 0.9, 0.99, 0.99, 1.2))
        self._until, self._there = 0.0, random.random() < 0.5

    def __call__(self, now: float) -> bool:
        """Whether it is there."""
        if self._stays:
            return True
        while now >= self._until:
            self._there = not self._there
            self._until += (self._there_for if self._there else self._gone_for) * self._random.uniform(0.9, 1.0) + 0.001
        return self._there


class RandomPlan:
    """Anything at each stage, in any order."""

    stages = (Stage.INITIAL_PERCEPTION, Stage.NAV_TO_STAGING_POSE, Stage.CONTROLLING, Stage.WAIT_FOR_CHARGE)
    motion = MotionLimits()
    lost = LostMarker

    def __init__(self, random: Random) -> None:
        self._random = random
        self._explores = Comes(random, 1.0)
        self._now = 0.0
        self._done, self._fails = random.choice((0.0, 0.02, 0.2)), random.choice((0.0, 0.01, 0.1))

    @property
    def poses(self) -> KnownPoses:
        return KnownPoses(filtered_dock=Pose(1.0), staging=Pose(0.5), explores=self._explores(self._now))

    def observe(self, observation: Observation) -> None:
        self._now = observation.now

    def controller(self, stage: Stage) -> Behavior:
        return self

    def correct(self, number: int) -> Behavior:
        return self

    def way_back(self) -> Behavior:
        return self

    def step(self, observation: Observation, dt: float) -> Step:
        drawn = self._random.random()
        if drawn < self._done:
            return Done()
        if drawn < self._done + self._fails:
            return Failed(self._random.choice(ERRORS)("failed"))
        return Velocity(self._random.choice((-0.1, 0.0, 0.1)), self._random.choice((-0.3, 0.0, 0.3)))


class Fog(ObstacleWatch):
    """Obstacles that come and go."""

    def __init__(self, settings: CollisionSettings, clear: Callable[[float], bool]) -> None:
        super().__init__(settings, Outline().points)
        self._is_free = clear

    def check(self, observation: Observation, docked: Pose | None, dt: float) -> bool:
        waits = not self._is_free(observation.now)
        self.reason = "fog" if waits else ""
        self._count(waits, dt)
        return not waits


class Navigator:
    """nav2, which answers and is reached now and then."""

    def __init__(self, random: Random) -> None:
        self._random = random

    def distance(self) -> float:
        if self._random.random() < 0.1:
            raise CannotNavigate("no pose")
        return 5.0

    def send(self) -> Ride:
        return Driving(self._random)

    def skip(self, reason: str) -> None:
        """Not told."""


class Driving:
    """A ride that ends now and then."""

    reason = "failed"

    def __init__(self, random: Random) -> None:
        self._random = random
        self.feedback = 0

    @property
    def state(self) -> RideState:
        self.feedback += 1
        return RideState.REACHED if self._random.random() < 0.001 else RideState.DRIVING

    def cancel(self) -> None:
        """It is not asked again."""


class Service:
    """The detector's, which is switched on after a while."""

    name = "detector"

    def __init__(self, random: Random) -> None:
        self._random = random

    def switch_on(self) -> bool:
        return True

    def answer(self) -> str | None:
        return "" if self._random.random() < 0.05 else None


def _limits(random: Random) -> DockTimeouts:
    return DockTimeouts(
        battery_stale_after=random.choice((0.2, 0.5, 2.0)),
        battery_lost_after=random.uniform(2.0, 5.0),
        odometry_timeout=random.uniform(0.5, 3.0),
        initial_perception_timeout=random.uniform(0.5, 3.0),
        staging_timeout=random.uniform(0.5, 3.0),
        dock_approach_timeout=random.uniform(0.5, 3.0),
        wait_charge_timeout=random.uniform(0.5, 3.0),
        retry_timeout=random.uniform(0.5, 2.0),
        charge_stable_for=random.choice((0.0, 0.5, 1.0, 3.0)),
        max_retries=random.randint(0, 3),
    )


def docking_goal(random: Random, plan: Plan | None = None) -> Goal:
    """A goal with limits of a few seconds, so that many of them can be exceeded.

    Args:
        random: Where all is drawn from.
        plan: None for one that does anything.
    """
    limits, recovery = _limits(random), RecoverySettings(max_corrections=random.randint(0, 2))
    source = random.choice((ChargingSource.STATUS, ChargingSource.STATUS, ChargingSource.POSE, ChargingSource.NONE))
    collision = CollisionSettings(obstacle_timeout=random.uniform(1.0, 4.0))
    objective = Docking(
        limits,
        charging=ChargingSettings(charging_source=source),
        recovery=random.choice((None, recovery)),
        search=SearchSettings(search_timeout=random.uniform(1.0, 4.0)),
    )
    fog = Fog(collision, Comes(random, collision.obstacle_timeout)) if random.random() < 0.5 else None
    goal = Goal(plan or RandomPlan(random), objective, 0.0, fog)
    if random.random() < 0.3:
        goal.navigate_first(
            Navigation(Navigator(random), NavigationSettings(max_staging_time=random.uniform(1.0, 5.0)))
        )
    if random.random() < 0.3:
        goal.detect_with(Detector(Service(random), random.uniform(0.5, 2.0)))
    return goal


def undocking_goal(random: Random) -> Goal:
    """The same to undock."""
    limits = UndockTimeouts(battery_stale_after=0.5, battery_lost_after=3.0, undocking_timeout=random.uniform(0.5, 5.0))
    return Goal(UndockPlan(0.7, MotionLimits()), Undocking(limits, assume_docked=True), 0.0)


def real_plan(random: Random) -> Plan:
    """One of ours; the dock may be known, and the robot may drive to look for it."""
    controller = random.choice((ControllerName.DOCK_POSE, ControllerName.INFRARED))
    settings = DockSettings(controller=controller)
    search = replace(settings.search, search_radius=random.choice((0.0, 4.0)))
    known = random.choice((None, Pose(random.uniform(-6.0, 6.0), random.uniform(-6.0, 6.0), random.uniform(-3.0, 3.0))))
    return make_plan(replace(settings, search=search, last_docked=known))


def run(goal: Goal, random: Random) -> tuple[float, Outcome | None]:
    """Let a goal go on with a robot on which all comes and goes.

    Returns:
        The seconds it took beyond `Goal.longest`, and its outcome; None where it went on for longer than it may.
    """
    longest, pause = goal.longest, random.choice(PAUSES)
    heard, located, held = Comes(random, 4.0), Comes(random, 1.5), Comes(random, 3.0)
    charges, seen, free = Comes(random, 1.0), Comes(random, 3.0), Comes(random, 3.0)
    late, dead = random.choice((0.0, 0.0, 0.4)), random.random() < 0.5
    expected = random.choice((None, Pose(2.0)))
    battery, odometry, marker, pose, now = None, None, None, Pose(), 0.0
    while now <= longest + LATE * pause:
        if heard(now):
            battery = BatteryReading(3 if dead or not charges(now) else 1, now - random.choice((0.0, 0.1)))
        if located(now):
            odometry = Odometry(pose, STANDSTILL, now - late)
        if seen(now):
            marker = MarkerDetection(Pose(2.0), now)
        step = goal.step(Observation(now, battery, odometry, marker, expected_dock=expected))
        if isinstance(step, Outcome):
            return now - longest, step
        if free(now) and not held(now):
            angle = pose.theta
            way, turn = step.velocity.linear_x * pause, step.velocity.angular_z * pause
            pose = Pose(pose.x + way * math.cos(angle), pose.y + way * math.sin(angle), angle + turn)
        now += pause
    return now - longest, None
