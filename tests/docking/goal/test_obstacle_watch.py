"""Obstacles on the way to the dock and away from it, in simulation: the robot waits and never touches one."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.errors import ErrorCode, Obstructed, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Scan, Velocity
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import ObstacleWatch, watch_obstacles
from docking.goal.outcome import Command, End, Outcome
from docking.goal.undock import Undocking
from docking.parameters import CollisionSettings, ControllerName, Dock, DockDirection, DockSettings, UndockSettings
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan
from docking.simulation.dock import DOCKED
from docking.simulation.dock import DockSettings as SimulatedDock
from docking.simulation.faults import IN_THE_WAY, Fault
from docking.simulation.laser import LaserSettings
from docking.simulation.marker import MarkerSettings
from docking.simulation.obstacle import Obstacle
from docking.simulation.robot import RobotSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
COLLISION = CollisionSettings(use_collision_detection=True, obstacle_timeout=5.0)


@dataclass
class Drive:
    """A simulated robot with a goal and a laser scanner."""

    collision: CollisionSettings = COLLISION
    settings: Settings = field(default_factory=lambda: Settings(start=Pose(-1.3, 0.0, 0.0)))
    undocks: bool = False
    dock: Dock = field(default_factory=Dock)
    blind: Callable[[Observation], Observation] = lambda observation: observation
    happen: Callable[["Drive"], None] = lambda drive: None
    stages: list[Stage] = field(default_factory=list)
    last: Command | None = None
    fastest: float = 0.0
    """While within 0.3 m of an obstacle."""

    def __post_init__(self) -> None:
        self.simulation = Simulation(self.settings, seed=5)
        self.simulation.scanning = True
        if self.undocks:
            undock = UndockSettings(collision=self.collision)
            plan = UndockPlan(undock.staging.distance, undock.motion)
            self.goal = Goal(plan, Undocking(undock.timeouts), 0.0, watch_obstacles(undock))
        else:
            dock = DockSettings(controller=ControllerName.DOCK_POSE, collision=self.collision, dock=self.dock)
            watch = watch_obstacles(dock, backward=self.dock.backward)
            self.goal = Goal(make_plan(dock), Docking(dock.timeouts), 0.0, watch)

    @property
    def gap(self) -> float:
        """From the robot to the nearest obstacle, in m."""
        robot = self.simulation.robot
        return min(
            (math.hypot(robot.x - one.x, robot.y - one.y) - one.radius - robot.radius)
            for one in (*self.simulation.obstacles, Obstacle(100.0, 0.0, 0.1))
        )

    def run(self, longest: float = 100.0) -> Outcome:
        simulation = self.simulation
        while simulation.time < longest:
            self.happen(self)
            step = self.goal.step(self.blind(simulation.observe()))
            assert self.gap > 0.0
            if isinstance(step, Outcome):
                simulation.run(1.0, STANDSTILL)
                assert self.gap > 0.0
                return step
            self.last = step
            if not self.stages or self.stages[-1] is not step.stage:
                self.stages.append(step.stage)
            assert step.velocity.finite
            if step.stage is Stage.WAIT_FOR_CLEARANCE:
                assert step.velocity == STANDSTILL
            if self.gap < 0.3:
                self.fastest = max(self.fastest, abs(step.velocity.linear_x))
            simulation.run(PERIOD, step.velocity)
        raise AssertionError(f"still in {self.stages} at {simulation.robot.pose}")


def appear(until: float = math.inf) -> Callable[[Drive], None]:
    """A pillar in front of the dock as soon as the robot drives towards it, for some seconds."""
    since: list[float] = []

    def happen(drive: Drive) -> None:
        if not since and drive.last is not None and drive.last.stage is Stage.NAV_TO_STAGING_POSE:
            since.append(drive.simulation.time)
        if since:
            drive.simulation.set_fault(Fault.OBSTACLE, drive.simulation.time < since[0] + until)

    return happen


def test_a_clear_way_is_driven_as_fast_as_without_the_scanner() -> None:
    times = []
    for collision in (COLLISION, CollisionSettings()):
        drive = Drive(collision)
        assert drive.run() == Outcome(End.SUCCEEDED)
        assert drive.simulation.contact
        assert Stage.WAIT_FOR_CLEARANCE not in drive.stages
        times.append(drive.simulation.time)
    assert times[0] == pytest.approx(times[1], abs=0.5)


def test_the_robot_waits_for_an_obstacle_and_goes_on() -> None:
    drive = Drive(settings=Settings(start=Pose(-1.3, 0.0, 0.0), obstacles=()), happen=appear(until=4.0))
    assert drive.run() == Outcome(End.SUCCEEDED)
    assert Stage.WAIT_FOR_CLEARANCE in drive.stages
    assert drive.simulation.contact
    assert drive.simulation.bumps == 0


def test_it_is_aborted_where_the_obstacle_stays() -> None:
    drive = Drive(happen=appear())
    outcome = drive.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.OBSTRUCTED, 0)
    assert outcome.error_msg == "the robot has waited for 5 s (obstacle_timeout): an obstacle is in the way"
    assert drive.last is not None
    assert (drive.last.stage, drive.last.error_code) == (Stage.WAIT_FOR_CLEARANCE, ErrorCode.OBSTRUCTED)
    assert drive.last.error_msg == "an obstacle is in the way: the robot waits"
    assert 0.02 < drive.gap < 0.25
    assert drive.simulation.bumps == 0


@pytest.mark.parametrize(
    "unkind",
    [
        {"command_delay": 0.3},
        {"robot": RobotSettings(linear_acceleration=0.2)},
        {"laser": LaserSettings(rate=5.0, noise=0.02)},
    ],
    ids=str,
)
def test_it_is_not_touched_by_a_robot_that_is_late_weak_or_sees_badly(unkind: dict[str, object]) -> None:
    drive = Drive(settings=replace(Settings(start=Pose(-1.3, 0.0, 0.0)), **unkind), happen=appear())
    assert drive.run().error_code is ErrorCode.OBSTRUCTED


@settings(max_examples=15)
@given(
    st.builds(Obstacle, st.floats(-0.9, -0.3), st.floats(-0.4, 0.4), st.floats(0.02, 0.12)),
    st.floats(1.0, 8.0),
    st.floats(1.0, 8.0),
)
def test_no_pillar_is_touched_wherever_and_whenever_it_comes(pillar: Obstacle, comes_at: float, stays: float) -> None:
    """It does not come where the robot is, or is about to be within half a second."""
    standing: list[bool] = []

    def happen(drive: Drive) -> None:
        robot, time = drive.simulation.robot, drive.simulation.time
        if not standing and time >= comes_at:
            distance = math.hypot(robot.x - pillar.x, robot.y - pillar.y) - pillar.radius - robot.radius
            standing.append(distance > 0.2)
        present = standing == [True] and time < comes_at + stays
        drive.simulation.settings = replace(drive.settings, obstacles=(pillar,) if present else ())

    drive = Drive(settings=Settings(start=Pose(-1.3, 0.2, -0.2)), happen=happen)
    assert drive.run().error_code in {ErrorCode.NONE, ErrorCode.OBSTRUCTED, ErrorCode.LOST_MARKER}
    assert drive.simulation.bumps == 0


def test_the_robot_slows_down_for_what_it_sees_from_afar() -> None:
    """A narrow pillar that does not hide the marker stands beside the way of the approach."""
    pillar = Obstacle(-0.45, -0.16, 0.03)
    drive = Drive(settings=Settings(start=Pose(-1.5, 0.0, 0.0), obstacles=(pillar,)))
    assert drive.run().error_code is ErrorCode.OBSTRUCTED
    assert drive.fastest < 0.16


def test_backing_out_is_watched_as_well() -> None:
    behind = Obstacle(-0.75, 0.0, 0.1)
    drive = Drive(settings=Settings(start=DOCKED, obstacles=(behind,)), undocks=True)
    outcome = drive.run()
    assert outcome.error_code is ErrorCode.OBSTRUCTED
    assert not drive.simulation.contact
    free = Drive(settings=Settings(start=DOCKED), undocks=True)
    assert free.run() == Outcome(End.SUCCEEDED)


def test_guide_rails_are_no_obstacles_in_front_of_the_dock() -> None:
    rails = tuple(Obstacle(-0.05 - 0.05 * number, side * 0.19, 0.015) for number in range(5) for side in (-1, 1))
    drive = Drive(settings=Settings(start=Pose(-1.3, 0.0, 0.0), obstacles=rails))
    assert drive.run() == Outcome(End.SUCCEEDED)


def test_a_robot_that_docks_backwards_watches_its_back() -> None:
    dock = Dock(dock_direction=DockDirection.BACKWARD)
    back = Settings(
        start=Pose(-1.3, 0.0, math.pi),
        dock=SimulatedDock(at_back=True),
        marker=MarkerSettings(camera_yaw=math.pi),
    )
    free = Drive(settings=back, dock=dock)
    assert free.run() == Outcome(End.SUCCEEDED)
    assert Stage.WAIT_FOR_CLEARANCE not in free.stages
    assert free.simulation.contact
    assert Drive(settings=back, dock=dock, happen=appear()).run().error_code is ErrorCode.OBSTRUCTED


@pytest.mark.parametrize("backward", [False, True])
def test_the_dock_is_no_obstacle_at_either_end_of_the_robot(backward: bool) -> None:
    """A robot 0.5 m before its docked pose; points of a dock, and of something in between."""
    outline, ahead = ((0.3, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.3, -0.1)), -1.0 if backward else 1.0
    reach = 0.1 if backward else 0.3
    for gap, blocked in ((0.5, False), (0.2, True)):
        watch = ObstacleWatch(COLLISION, outline, backward=backward)
        scan = Scan(np.array(((ahead * (reach + gap), 0.0),)), 0.0)
        odometry = Odometry(Pose(), STANDSTILL, 0.0)
        docked = Pose(ahead * 0.5)
        assert watch.check(Observation(0.0, odometry=odometry, scan=scan), docked, 0.05)
        assert watch.stops(Velocity(ahead * 0.5)) is blocked


def test_what_belongs_to_the_robot_does_not_hide_the_dock() -> None:
    outline = ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2))
    for x, hides in ((0.1, False), (0.25, True)):
        watch = ObstacleWatch(COLLISION, outline)
        seen = Observation(0.0, odometry=Odometry(Pose(), STANDSTILL, 0.0), scan=Scan(np.array(((x, 0.0),)), 0.0))
        assert watch.check(seen, Pose(1.0), 0.05)
        assert watch.stops(STANDSTILL) is hides


def test_no_scan_for_a_while_is_not_said_of_one_that_never_came() -> None:
    watch = ObstacleWatch(replace(COLLISION, scan_timeout=10.0), ((0.2, 0.2), (-0.2, 0.0), (0.2, -0.2)))
    for step in range(30):
        assert not watch.check(Observation(0.05 * step), None, 0.05)
    assert watch.reason == "no scan received yet: the robot waits"


def test_without_a_scan_the_robot_does_not_move() -> None:
    drive = Drive(blind=lambda observation: replace(observation, scan=None))
    outcome = drive.run()
    assert (outcome.error_code, drive.stages[-1]) == (ErrorCode.SCAN_LOST, Stage.WAIT_FOR_CLEARANCE)
    assert drive.simulation.robot.pose == Pose(-1.3, 0.0, 0.0)


def test_a_scanner_that_falls_silent_stops_the_robot() -> None:
    frozen: list[Observation] = []

    def blind(observation: Observation) -> Observation:
        if observation.now < 3.0:
            frozen[:] = [observation]
        return replace(observation, scan=frozen[0].scan)

    drive = Drive(blind=blind)
    outcome = drive.run()
    assert outcome.error_code is ErrorCode.SCAN_LOST
    assert outcome.error_msg == "the robot has waited for 5 s (obstacle_timeout): there is no scan"
    assert drive.last is not None
    assert (drive.last.error_code, drive.last.retries) == (ErrorCode.SCAN_LOST, 0)
    assert drive.last.error_msg == "no scan for over 0.5 s (scan_timeout): the robot waits"
    assert drive.simulation.time < 3.0 + 0.5 + 5.0 + 1.5


SQUARE = ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2))
FORWARD = Velocity(0.2)
IN_FRONT = ((0.3, 0.0),)
TICK = 0.25
"""Seconds between two looks. Sums of it are exact."""


def view(*points: tuple[float, float], now: float = 0.0, age: float = 0.0, robot: Pose | None = None) -> Observation:
    scan = Scan(np.array(points).reshape(-1, 2), now - age)
    return Observation(now, odometry=Odometry(robot or Pose(), STANDSTILL, now), scan=scan)


def blocked_watch(**settings: float) -> ObstacleWatch:
    """A robot that has been stopped by an obstacle in front of it."""
    watch = ObstacleWatch(replace(COLLISION, **settings), SQUARE)  # type: ignore[arg-type]
    assert watch.check(view(*IN_FRONT), None, TICK)
    assert watch.stops(FORWARD)
    return watch


def test_before_the_first_scan_nothing_is_in_the_way() -> None:
    watch = ObstacleWatch(COLLISION, SQUARE)
    assert (watch.reason, watch.lost, watch.stops(STANDSTILL), watch.stops(FORWARD)) == ("", False, False, False)
    assert watch.slow_down(FORWARD) == FORWARD


def test_the_robot_goes_on_when_the_way_has_been_clear_for_half_a_second() -> None:
    watch = blocked_watch()
    for _ in range(4):
        assert not watch.check(view(*IN_FRONT), None, TICK)
        assert watch.reason == "an obstacle is in the way: the robot waits"
    assert not watch.check(view(), None, TICK)
    assert not watch.check(view(*IN_FRONT), None, TICK), "it is back"
    assert not watch.check(view(), None, TICK)
    assert watch.check(view(), None, TICK)
    assert (watch.reason, watch.lost) == ("", False)
    assert watch.check(view(), None, TICK)


def test_the_robot_waits_for_obstacle_timeout_and_no_longer() -> None:
    watch = blocked_watch(obstacle_timeout=1.0)
    for _ in range(4):
        assert not watch.check(view(*IN_FRONT), None, TICK)
    with pytest.raises(Obstructed):
        watch.check(view(*IN_FRONT), None, TICK)


@pytest.mark.parametrize(("free", "waits"), [(8, 2), (9, 4)])
def test_the_time_that_it_has_waited_is_forgotten_after_more_than_two_seconds(free: int, waits: int) -> None:
    watch = blocked_watch(obstacle_timeout=1.0)
    assert not watch.check(view(*IN_FRONT), None, TICK)
    assert not watch.check(view(), None, TICK)
    assert watch.check(view(), None, TICK)
    for _ in range(free - 1):
        assert watch.check(view(*IN_FRONT), None, TICK)
    assert watch.stops(FORWARD)
    for _ in range(waits):
        assert not watch.check(view(*IN_FRONT), None, TICK)
    with pytest.raises(Obstructed):
        watch.check(view(*IN_FRONT), None, TICK)


def test_a_scan_may_be_as_old_as_scan_timeout() -> None:
    watch = ObstacleWatch(COLLISION, SQUARE)
    assert watch.check(view(now=1.0, age=0.5), None, TICK)
    assert not watch.check(view(now=1.0, age=0.75), None, TICK)
    assert (watch.lost, watch.reason) == (True, "no scan for over 0.5 s (scan_timeout): the robot waits")


def test_the_first_scan_may_take_a_second() -> None:
    watch = ObstacleWatch(COLLISION, SQUARE)
    said = []
    for _ in range(6):
        assert not watch.check(Observation(0.0), None, TICK)
        said.append(watch.reason)
    assert said == [""] * 5 + ["no scan received yet: the robot waits"]


@pytest.mark.parametrize(
    ("along", "aside", "hides"),
    [
        (0.5, 0.0, True),
        (0.5, -0.15, True),
        (0.5, -0.5, False),
        (-0.5, 0.0, False),
        (1.5, 0.0, False),
    ],
)
def test_what_hides_the_dock_is_between_it_and_the_robot(along: float, aside: float, hides: bool) -> None:
    """The docked pose is 1 m away, 0.5 rad to the left of where the robot looks; the dock is to its left."""
    robot, towards = Pose(1.0, 2.0, 0.75), Pose(theta=0.5)
    docked = robot.compose(towards).compose(Pose(1.0, 0.0, math.pi / 2))
    point = towards.compose(Pose(along, aside))
    watch = ObstacleWatch(replace(COLLISION, dock_collision_threshold=0.0), SQUARE)
    world = robot.compose(Pose(point.x, point.y))
    assert watch.check(view((world.x, world.y), robot=robot), docked, TICK)
    assert watch.stops(STANDSTILL) is hides


def test_the_dock_is_beyond_the_front_of_a_robot_that_is_longer_in_front() -> None:
    outline = ((0.4, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.4, -0.1))
    for reach, is_dock in ((0.45, True), (0.2, False)):
        watch = ObstacleWatch(COLLISION, outline)
        assert watch.check(view((0.5 + reach, 0.0)), Pose(0.5), TICK)
        assert watch.stops(Velocity(0.5)) is not is_dock


def test_the_way_is_looked_at_from_where_a_command_takes_effect() -> None:
    drive = Drive(settings=Settings(start=Pose(-1.3, 0.0, 0.0), command_delay=0.3))
    ahead: list[float] = []

    class Spy(ObstacleWatch):
        def check(self, observation: Observation, docked: Pose | None, dt: float) -> bool:
            known = drive.simulation.observe().odometry
            assert known is not None
            assert observation.odometry is not None
            ahead.append(observation.odometry.pose.distance_to(known.pose))
            return super().check(observation, docked, dt)

    dock = DockSettings(controller=ControllerName.DOCK_POSE)
    drive.goal = Goal(make_plan(dock), Docking(dock.timeouts), 0.0, Spy(COLLISION, dock.outline.points))
    assert drive.run() == Outcome(End.SUCCEEDED)
    assert max(ahead) > 0.03


def test_it_is_off_unless_it_is_wanted() -> None:
    assert watch_obstacles(DockSettings()) is None
    assert isinstance(watch_obstacles(DockSettings(collision=COLLISION)), ObstacleWatch)
    assert IN_THE_WAY.radius > 0.0
