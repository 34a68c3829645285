import math
from dataclasses import replace

import numpy as np
import pytest

from docking.core.battery import Battery, BatteryReading
from docking.core.errors import DockedUnknown, ErrorCode, FailedToUndock, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Scan, Velocity
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.objective import Progress
from docking.goal.obstacle_watch import ObstacleWatch
from docking.goal.outcome import Command, End, Outcome
from docking.goal.undock import Undocking
from docking.parameters import ChargingSettings, ChargingSource, CollisionSettings, MotionLimits, UndockTimeouts
from docking.parameters.collision import Outline
from docking.plans.undock import UndockPlan
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
MOTION = MotionLimits()


def docked() -> Simulation:
    simulation = Simulation(Settings(start=DOCKED), seed=4)
    simulation.run(0.5)
    assert simulation.charging
    return simulation


def undock_goal(
    timeouts: UndockTimeouts | None = None,
    started_at: float = 0.0,
    memory: DockMemory | None = None,
    *,
    assume_docked: bool = False,
) -> Goal:
    objective = Undocking(timeouts or UndockTimeouts(), memory, assume_docked=assume_docked)
    return Goal(UndockPlan(0.7, MOTION), objective, started_at)


def undock(
    simulation: Simulation,
    limits: UndockTimeouts | None = None,
    memory: DockMemory | None = None,
    *,
    keep_charging: bool = False,
    assume_docked: bool = False,
) -> Outcome:
    goal = undock_goal(limits, simulation.time, memory, assume_docked=assume_docked)
    speed, begun = 0.0, simulation.time
    while simulation.time < begun + 100.0:
        observation = simulation.observe()
        if keep_charging:
            observation = replace(observation, battery=BatteryReading(1, observation.now))
        step = goal.step(observation)
        if isinstance(step, Outcome):
            simulation.run(1.0, STANDSTILL)
            assert simulation.robot.velocity == STANDSTILL
            return step
        if step.stage is Stage.UNDOCKING:
            assert -MOTION.v_linear_max <= step.velocity.linear_x <= 0.0
            assert (
                abs(step.velocity.linear_x - speed) <= MOTION.a_linear_max * PERIOD + 1e-9
                or step.velocity == STANDSTILL
            )
            speed = step.velocity.linear_x
        simulation.run(PERIOD, step.velocity)
    raise AssertionError(f"still at {simulation.robot.pose}")


def test_it_backs_out_to_the_staging_pose_and_charges_no_longer() -> None:
    simulation = docked()
    assert undock(simulation) == Outcome(End.SUCCEEDED)
    assert not simulation.charging
    assert simulation.robot.pose.distance_to(Pose(-0.9)) < 0.05
    assert abs(simulation.robot.theta) < math.radians(5.0)


def test_where_nothing_tells_whether_it_is_docked_it_does_not_move_and_is_no_success() -> None:
    simulation = Simulation(seed=4)
    begun = simulation.time
    outcome = undock(simulation)
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.DOCKED_UNKNOWN)
    assert "2 (DISCHARGING)" in outcome.error_msg
    assert "assume_docked" in outcome.error_msg
    assert simulation.time == pytest.approx(begun + 1.0)


def test_it_backs_out_all_the_same_where_it_is_to_assume_that_it_is_docked() -> None:
    simulation = docked()
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    simulation.run(1.0)
    assert undock(simulation, assume_docked=True) == Outcome(End.SUCCEEDED)
    assert simulation.robot.x < -0.85


def test_a_robot_that_has_undocked_has_succeeded_at_once() -> None:
    simulation, memory = docked(), DockMemory()
    assert undock(simulation, memory=memory) == Outcome(End.SUCCEEDED)
    begun, place = simulation.time, simulation.robot.pose
    assert undock(simulation, memory=memory) == Outcome(End.SUCCEEDED)
    assert simulation.time == pytest.approx(begun + 1.0)
    assert simulation.robot.pose.distance_to(place) < 0.01


def test_a_robot_that_was_moved_since_is_not_known_to_be_anywhere() -> None:
    simulation, memory = docked(), DockMemory()
    undock(simulation, memory=memory)
    simulation.run(2.0, Velocity(-0.2, 0.0))
    assert undock(simulation, memory=memory).error_code is ErrorCode.DOCKED_UNKNOWN


@pytest.mark.parametrize("at", [DOCKED, None])
def test_a_full_robot_whose_charger_switched_off_is_docked_still(at: Pose | None) -> None:
    simulation = docked()
    odometry = simulation.observe().odometry
    assert odometry is not None
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    simulation.run(1.0)
    assert not simulation.charging
    memory = DockMemory(True, at and odometry.pose)
    assert undock(simulation, memory=memory) == Outcome(End.SUCCEEDED)
    assert simulation.robot.x < -0.85
    assert memory.docked is False


def lifted() -> tuple[Simulation, DockMemory]:
    """A robot that was docked, and that someone has put elsewhere since: odometry has not noticed."""
    simulation = docked()
    odometry = simulation.observe().odometry
    assert odometry is not None
    simulation.place(Pose(-2.0, 1.0, 0.5))
    simulation.run(1.0)
    return simulation, DockMemory(True, odometry.pose)


def test_a_robot_that_was_lifted_off_its_dock_does_not_back_out() -> None:
    simulation, memory = lifted()
    place = simulation.robot.pose
    outcome = undock(simulation, memory=memory)
    assert outcome.error_code is ErrorCode.DOCKED_UNKNOWN
    assert (
        "its battery is 2 (DISCHARGING) at 24 %: it was lifted off its dock, or the dock has no power"
        in outcome.error_msg
    )
    assert simulation.robot.pose.distance_to(place) < 0.001
    assert undock(simulation, memory=memory, assume_docked=True) == Outcome(End.SUCCEEDED)


@pytest.mark.parametrize(("status", "percentage"), [(2, 0.96), (2, math.nan), (3, 0.5)])
def test_a_battery_that_may_be_at_its_charger_does_not_contradict_the_memory(status: int, percentage: float) -> None:
    memory = DockMemory(True, Pose())
    objective, battery = Undocking(UndockTimeouts(), memory), BatteryReading(status, 1.0, percentage=percentage)
    observation = Observation(1.0, battery, Odometry(Pose(), STANDSTILL, 1.0))
    assert not objective.is_reached(observation, battery, Progress(True, False, None))
    assert objective.is_reached(observation, battery, Progress(True, True, None))


def lifted_goal(
    source: ChargingSource, percentage: float = 0.5, status: int = 2, *, full: bool = False, watched: bool = False
) -> tuple[Outcome, float, float]:
    """Undock where odometry says that the robot has not moved since it was docked, and the battery discharges.

    Args:
        source: What tells that the battery charges.
        percentage: State of charge.
        status: Of the battery.
        full: Whether the battery was full since the robot has docked.
        watched: Whether a scan shows what is behind.

    Returns:
        The outcome, the fastest command backwards in m/s, and the way in m.
    """
    battery, memory, now, pose, fastest = Battery(), DockMemory(), 1.0, Pose(), 0.0
    memory.note(True, pose, 0.5)
    battery.update(BatteryReading(1, 0.9 if full else 0.1, percentage=1.0))
    charging = ChargingSettings(charging_source=source)
    objective = Undocking(UndockTimeouts(), memory, charging=charging, slowest=0.7 / MOTION.v_linear_min)
    watch = ObstacleWatch(CollisionSettings(use_collision_detection=True), Outline().points) if watched else None
    goal = Goal(UndockPlan(0.7, MOTION), objective, now, watch)
    longest = goal.longest
    angles = np.radians(np.arange(0.0, 360.0, 2.0))
    while now < 1.0 + longest:
        battery.update(BatteryReading(status, now, percentage=percentage, current=-1.5))
        scan = Scan(3.0 * np.column_stack((np.cos(angles), np.sin(angles))), now) if watched else None
        step = goal.step(Observation(now, battery.latest, Odometry(pose, STANDSTILL, now), scan=scan))
        if isinstance(step, Outcome):
            return step, fastest, -pose.x
        fastest = max(fastest, -step.velocity.linear_x)
        pose, now = Pose(pose.x + step.velocity.linear_x * PERIOD), now + PERIOD
    raise AssertionError("it goes on")


SOURCES = [ChargingSource.STATUS, ChargingSource.CURRENT, ChargingSource.POSE]


@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("percentage", [0.2, 0.69, 0.71, 0.94, 0.96, math.nan])
@pytest.mark.parametrize("status", [0, 2])
def test_a_robot_that_may_have_been_lifted_off_its_dock_drives_slowly_or_not_at_all(
    source: ChargingSource, percentage: float, status: int, full: bool
) -> None:
    outcome, fastest, _ = lifted_goal(source, percentage, status, full=full)
    assert fastest <= MOTION.v_linear_min + 1e-9
    assert outcome.error_code is ErrorCode.DOCKED_UNKNOWN or "it may have been lifted off" in " ".join(outcome.doubts)


@pytest.mark.parametrize("source", [ChargingSource.STATUS, ChargingSource.CURRENT])
def test_below_95_percent_a_battery_that_discharges_and_was_not_full_is_at_no_charger(source: ChargingSource) -> None:
    outcome, fastest, way = lifted_goal(source)
    assert (outcome.error_code, fastest, way) == (ErrorCode.DOCKED_UNKNOWN, 0.0, 0.0)
    assert "assume_docked" in outcome.error_msg


@pytest.mark.parametrize("source", SOURCES)
def test_a_charger_that_waits_until_the_battery_is_lower_is_left_slowly(source: ChargingSource) -> None:
    outcome, _, way = lifted_goal(source, 0.85, full=True)
    assert outcome.end is End.SUCCEEDED
    assert way == pytest.approx(0.7, abs=0.01)
    assert "only odometry tells that the robot is on its dock" in outcome.doubts[0]
    assert lifted_goal(source, 0.85, full=True, watched=True)[1] == pytest.approx(MOTION.v_linear_back)


def test_a_battery_that_was_full_before_the_robot_docked_says_nothing() -> None:
    memory = DockMemory()
    memory.note(True, Pose(), 5.0)
    memory.note(True, Pose(0.05), 9.0)
    assert memory.since == 5.0
    memory.note(False, Pose(1.0), 20.0)
    memory.note(True, Pose(0.05), 30.0)
    assert memory.since == 30.0


def test_a_goal_that_fails_on_the_dock_leaves_it_known_that_the_robot_is_docked() -> None:
    simulation, memory = docked(), DockMemory()
    simulation.set_fault(Fault.STUCK_WHEEL, True)
    assert undock(simulation, memory=memory).error_code is ErrorCode.FAILED_TO_UNDOCK
    assert memory.docked is True


def test_a_battery_that_goes_on_charging_is_a_failure() -> None:
    simulation = docked()
    outcome = undock(simulation, keep_charging=True)
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_UNDOCK)
    assert "charging" in outcome.error_msg
    assert simulation.time < 23.0


def test_a_robot_that_is_held_fast_has_failed_to_undock() -> None:
    simulation = docked()
    simulation.set_fault(Fault.STUCK_WHEEL, True)
    outcome = undock(simulation)
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_UNDOCK)
    assert "blocked_after" in outcome.error_msg
    assert simulation.time < 6.0


def test_a_way_that_takes_too_long_is_a_failure() -> None:
    outcome = undock(docked(), UndockTimeouts(undocking_timeout=1.0))
    assert outcome.error_code is ErrorCode.FAILED_TO_UNDOCK
    assert "did not get away" in outcome.error_msg


def test_without_odometry_it_does_not_move_and_gives_up() -> None:
    goal = undock_goal()
    for number in range(50):
        now = 0.1 * number
        step = goal.step(Observation(now, BatteryReading(1, now)))
        assert isinstance(step, Command)
        assert step.velocity == STANDSTILL
        assert (step.stage is Stage.WAIT_FOR_ODOMETRY) is (now > 1.0)
    assert goal.step(Observation(5.1, BatteryReading(1, 5.1))).error_code is ErrorCode.ODOMETRY_LOST


def test_it_waits_for_a_silent_battery() -> None:
    goal, odometry = (
        undock_goal(UndockTimeouts(battery_lost_after=5.0)),
        Odometry(Pose(), STANDSTILL, 0.0),
    )
    step = goal.step(Observation(0.0, None, odometry))
    assert isinstance(step, Command)
    assert (step.stage, step.velocity) == (Stage.WAIT_FOR_BATTERY, STANDSTILL)
    assert goal.step(Observation(5.1, None, odometry)).error_code is ErrorCode.BATTERY_LOST


def test_the_first_outcome_stays() -> None:
    simulation = docked()
    goal = undock_goal(None, simulation.time)
    assert isinstance(goal.step(simulation.observe()), Command)
    canceled = goal.cancel()
    assert goal.step(simulation.observe()) is canceled


def look(objective: Undocking, status: int, at: Pose | None, *, finished: bool = False) -> bool:
    odometry = None if at is None else Odometry(at, STANDSTILL, 1.0)
    battery = BatteryReading(status, 1.0)
    return objective.is_reached(Observation(1.0, battery, odometry), battery, Progress(True, finished, None))


def test_once_the_battery_has_charged_the_robot_is_docked_until_it_has_backed_out() -> None:
    objective = Undocking(UndockTimeouts())
    assert not look(objective, 1, Pose())
    assert not look(objective, 3, Pose(-1.0)), "on its way out, although it is where it is not known to be docked"
    assert not look(objective, 1, Pose(-1.0), finished=True)
    assert look(objective, 3, Pose(-1.0), finished=True)


def test_nothing_is_assumed_unless_it_is_wanted() -> None:
    with pytest.raises(DockedUnknown):
        look(Undocking(UndockTimeouts()), 3, Pose())


def test_a_robot_off_its_dock_is_that_only_where_odometry_tells_it() -> None:
    memory = DockMemory()
    memory.note(False, Pose())
    objective = Undocking(UndockTimeouts(), memory)
    assert not look(objective, 3, None)
    assert look(objective, 3, Pose())


@pytest.mark.parametrize(
    ("finished", "message"),
    [(True, "the battery is still charging"), (False, "the robot did not get away from the dock")],
)
def test_its_time_limit_is_a_parameter(finished: bool, message: str) -> None:
    deadline = Undocking(UndockTimeouts()).deadline(Stage.UNDOCKING, finished)
    assert deadline is not None
    assert (deadline.parameter, deadline.error, deadline.message) == ("undocking_timeout", FailedToUndock, message)
