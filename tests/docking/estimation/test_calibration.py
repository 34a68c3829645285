"""Calibration in simulation: the measured pose, and every reason to refuse."""

import math
from dataclasses import replace
from itertools import cycle

import pytest

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, MarkerDetection, Observation, Odometry
from docking.estimation.calibration import LONGEST, SHORTEST, SILENT, Calibration, CalibrationError, DockCalibration
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DT = 0.05


def simulation(seed: int = 1, start: Pose = DOCKED, **marker: object) -> Simulation:
    return Simulation(Settings(start=start, marker=replace(MarkerSettings(), **marker)), seed)


def calibrate(robot: Simulation, *, push: Pose | None = None) -> Calibration:
    measurement = DockCalibration(robot.time)
    result = None
    while result is None:
        robot.run(DT)
        observation = robot.observe()
        if push is not None and robot.time > 1.0 and observation.odometry is not None:
            moved = observation.odometry.pose.compose(push)
            observation = replace(observation, odometry=replace(observation.odometry, pose=moved))
        result = measurement.step(observation)
    return result


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("noise", "angle_noise"), [(0.001, 0.1), (0.01, 1.0), (0.03, 3.0)])
def test_the_docked_pose_is_measured_to_a_fraction_of_the_noise(seed: int, noise: float, angle_noise: float) -> None:
    result = calibrate(simulation(seed, noise=noise, angle_noise=math.radians(angle_noise)))
    error = result.docked.relative_to(DOCKED)
    assert math.hypot(error.x, error.y) < 0.5 * noise + 0.001
    assert abs(error.theta) < math.radians(0.5 * angle_noise)
    assert result.distance_noise == pytest.approx(noise, rel=0.5, abs=0.0005 + 0.2 * math.radians(angle_noise))
    assert SHORTEST <= result.seconds <= LONGEST + DT


def test_it_does_not_matter_how_the_robot_stands_on_its_dock_but_as_seen_from_the_marker() -> None:
    standing = Pose(-0.4, 0.1, -0.2)
    error = calibrate(simulation(start=standing)).docked.relative_to(standing)
    assert math.hypot(error.x, error.y) < 0.005
    assert abs(error.theta) < math.radians(0.5)


def test_outliers_do_not_count() -> None:
    robot = simulation()
    robot.set_fault(Fault.WRONG_DETECTIONS, active=True)
    error = calibrate(robot).docked.relative_to(DOCKED)
    assert math.hypot(error.x, error.y) < 0.01
    assert abs(error.theta) < math.radians(1.0)


def test_a_slow_camera_gets_more_time() -> None:
    result = calibrate(simulation(rate=2.0, drop_outs=0.0))
    assert SHORTEST < result.seconds <= LONGEST + DT
    assert result.count >= 10


def refusal(robot: Simulation, **more: Pose) -> str:
    with pytest.raises(CalibrationError) as refused:
        calibrate(robot, **more)
    return str(refused.value)


def test_a_marker_that_is_not_detected() -> None:
    robot = simulation()
    robot.set_fault(Fault.OCCLUDED_MARKER, active=True)
    robot.run(0.5)
    assert "only" in refusal(robot) or "not detected" in refusal(robot)
    assert robot.time < LONGEST + 20.0


def test_a_marker_that_is_rarely_detected() -> None:
    assert "only" in refusal(simulation(rate=0.5))


@pytest.mark.parametrize("marker", [{"noise": 0.3}, {"angle_noise": 0.5}, {"ghosts": 0.5}])
def test_detections_that_spread_too_much(marker: dict[str, float]) -> None:
    assert "spread too much" in refusal(simulation(**marker))


@pytest.mark.parametrize("push", [Pose(0.02), Pose(0.0, -0.02), Pose(0.0, 0.0, 0.1)], ids=str)
def test_a_robot_that_moves(push: Pose) -> None:
    assert refusal(simulation(), push=push) == "the robot moved: it must stand still on its dock"


def test_odometry_that_drifts_at_a_standstill() -> None:
    robot, measurement, result = simulation(noise=0.0, angle_noise=0.0), DockCalibration(0.0), None
    while result is None:
        robot.run(DT)
        seen = robot.observe()
        assert seen.odometry is not None
        assert seen.marker is not None
        drift = Pose(theta=math.radians(0.3) * robot.time)
        seen = replace(
            seen,
            odometry=replace(seen.odometry, pose=drift.compose(seen.odometry.pose)),
            marker=replace(seen.marker, pose=drift.compose(seen.marker.pose)),
        )
        result = measurement.step(seen)
    error = result.docked.relative_to(DOCKED)
    assert math.hypot(error.x, error.y) < 0.001
    assert abs(error.theta) < math.radians(0.05)


def test_odometry_that_does_not_come() -> None:
    measurement = DockCalibration(0.0)
    assert measurement.step(Observation(0.1)) is None
    with pytest.raises(CalibrationError, match="no odometry"):
        measurement.step(Observation(SILENT + 0.1))


def test_odometry_that_falls_silent() -> None:
    robot = simulation()
    robot.run(DT)
    measurement, silent = DockCalibration(robot.time), robot.observe()
    assert measurement.step(replace(silent, now=silent.now + SILENT)) is None
    with pytest.raises(CalibrationError, match="no odometry"):
        measurement.step(replace(silent, now=silent.now + SILENT + 0.1))


def measure(seen: list[Pose], period: float = DT) -> Calibration:
    """For a robot that detects its marker at these poses, again and again."""
    measurement, now = DockCalibration(0.0), 0.0
    for pose in cycle(seen):
        now += period
        odometry = Odometry(Pose(), STANDSTILL, now)
        if result := measurement.step(Observation(now, odometry=odometry, marker=MarkerDetection(pose, now))):
            return result
    raise AssertionError("there are no poses")


@pytest.mark.parametrize("step", [Pose(0.01), Pose(0.0, 0.001), Pose(0.0, 0.0, 0.02)], ids=str)
def test_detections_that_are_rounded_are_no_outliers(step: Pose) -> None:
    seen = Pose(0.2)
    result = measure([*[seen] * 5, *[seen.compose(step)] * 4])
    assert result.docked.distance_to(seen.inverse()) < 0.005
    assert abs(result.docked.theta) <= 0.01


@pytest.mark.parametrize("agreeing", [0, 1])
def test_detections_that_do_not_agree_at_all(agreeing: int) -> None:
    seen = [Pose()] * agreeing + [Pose(1.0)] * (4 - agreeing) + [Pose(0.0, 1.0)] * 3 + [Pose(0.0, 0.0, 1.0)] * 3
    with pytest.raises(CalibrationError, match=rf"spread too much: .* {10 - agreeing} of 10 were left out"):
        measure(seen, 1.0)
