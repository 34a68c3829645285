"""The faults of the dock simulator over DDS, each switched on and off."""

import time
from itertools import pairwise

import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from docking.core.geometry import Pose
from docking.ros.geometry import seconds_of
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from tests.support.observer import Observer, Recording
from tests.support.simulator import (
    START,
    SimulatorControls,
    dock_simulator,
    moving,
    near,
    pose_of,
    velocity,
    wait_for_new,
)
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

CHARGING, DISCHARGING, NOT_CHARGING = 1, 2, 3


def assert_silent(recording: Recording, seconds: float = 1.0) -> None:
    """Nothing comes for a while, once what was under way has arrived."""
    time.sleep(0.3)
    before = len(recording.messages)
    time.sleep(seconds)
    assert len(recording.messages) == before


def test_on_the_dock_it_charges_and_a_dead_charger_does_not(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        battery = observer.record(BatteryState, "battery_status")
        battery.wait_for(lambda state: state.power_supply_status == DISCHARGING)
        controls.place(DOCKED)
        charging = battery.wait_for(lambda state: state.power_supply_status == CHARGING)
        assert charging.current > 0.0
        controls.wait_for_status(contact="true", docked="true")
        controls.switch("dead_charger")
        dead = battery.wait_for(lambda state: state.power_supply_status == NOT_CHARGING)
        assert dead.current < 0.0
        controls.wait_for_status(contact="true", docked="false", dead_charger="true")
        controls.switch("dead_charger", on=False)
        wait_for_new(battery, lambda state: state.power_supply_status == CHARGING)
        controls.place(START)
        wait_for_new(battery, lambda state: state.power_supply_status == DISCHARGING)
        controls.wait_for_status(contact="false", docked="false")


def test_each_fault_is_told_and_reset_takes_all_back(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        truth = observer.record(Odometry, "ground_truth")
        for fault in Fault:
            controls.switch(fault)
            controls.wait_for_status(**{fault.value: "true"})
        controls.place(Pose(-1.0, 0.0, 0.0))
        wait_for_new(truth, lambda message: near(message, Pose(-1.0, 0.0, 0.0)))
        controls.reset()
        controls.wait_for_status(**dict.fromkeys(Fault, "false"))
        wait_for_new(truth, lambda message: near(message, START))


@pytest.mark.parametrize(
    ("fault", "kind", "topic"),
    [
        (Fault.SILENT_BATTERY, BatteryState, "battery_status"),
        (Fault.OCCLUDED_MARKER, PoseStamped, "detected_dock_pose"),
    ],
)
def test_what_a_fault_silences_comes_back(
    fault: Fault, kind: type, topic: str, domain: int, observer: Observer
) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        heard = observer.record(kind, topic)
        heard.wait_for(lambda _: True)
        controls.switch(fault)
        assert_silent(heard)
        controls.switch(fault, on=False)
        wait_for_new(heard)


def test_a_stuck_wheel_keeps_it_from_getting_away(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        truth = observer.record(Odometry, "ground_truth")
        controls.switch("stuck_wheel")
        with observer.publishing(velocity(-0.2), "cmd_vel"):
            truth.wait_for(moving)
            wait_until(lambda: not moving(truth.messages[-1]), "the motors are switched off")
            assert pose_of(truth.messages[-1]).distance_to(START) < 0.1
            controls.switch("stuck_wheel", on=False)
            wait_for_new(truth, moving)


def test_a_percentage_of_a_hundred(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        battery = observer.record(BatteryState, "battery_status")
        controls.switch("percentage_0_to_100")
        battery.wait_for(lambda state: state.percentage == pytest.approx(24.0, abs=0.1))


def test_repeated_odometry_is_published_again_with_new_stamps(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        odometry = observer.record(Odometry, "odom")
        controls.switch("repeated_odometry")
        with observer.publishing(velocity(0.1, 0.2), "cmd_vel"):
            wait_until(lambda: _repeats(odometry) > 10, "repeated odometry")


def _repeats(odometry: Recording) -> int:
    """How many messages while the robot moved say the same as the one before, but later."""
    return sum(
        before.pose == after.pose and before.twist == after.twist and before.header.stamp != after.header.stamp
        for before, after in pairwise(odometry.messages)
        if before.twist.twist.linear.x > 0.05
    )


def test_future_detections_are_published_with_their_stamps(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        detections = observer.record(PoseStamped, "detected_dock_pose")
        assert _ahead(detections.wait_for(lambda _: True)) < 0.1
        controls.switch("future_detections")
        wait_for_new(detections, lambda message: _ahead(message) > 0.3)


def _ahead(message: PoseStamped) -> float:
    """How far its stamp is in the future, in s."""
    return seconds_of(message.header.stamp) - time.time()
