"""The dock simulator over DDS."""

import math
import signal
import time

import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Range
from std_msgs.msg import Bool

from docking.core.geometry import Pose
from docking.nodes.simulator import LATCHED
from tests.support.docking import LOW
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, Process, ros_environment
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

DISCHARGING, FULL = 2, 4


def test_the_sensors_are_heard_in_their_frames_and_rates(domain: int, observer: Observer) -> None:
    topics: dict[str, tuple[type, str, float]] = {
        "odom": (Odometry, "odom", 30.0),
        "ground_truth": (Odometry, "world", 30.0),
        "detected_dock_pose": (PoseStamped, "base_link", 15.0),
        "infrared/left": (Range, "infrared_left", 15.0),
        "infrared/center": (Range, "infrared_center", 15.0),
        "infrared/right": (Range, "infrared_right", 15.0),
        "battery_status": (BatteryState, "base_link", 10.0),
    }
    with dock_simulator(domain, "marker_drop_outs:=0.0", "start_y:=0.0", "start_theta:=0.0"):
        heard = {topic: observer.record(kind, topic) for topic, (kind, _, _) in topics.items()}
        for recording in heard.values():
            recording.wait_for(lambda _: True)
        before = {topic: len(recording.messages) for topic, recording in heard.items()}
        began = time.monotonic()
        time.sleep(2.0)
        seconds = time.monotonic() - began
        for topic, (_, frame, rate) in topics.items():
            messages = heard[topic].messages
            assert messages[-1].header.frame_id == frame
            assert 0.5 * rate < (len(messages) - before[topic]) / seconds < 1.2 * rate, topic
            stamps = [message.header.stamp.sec + message.header.stamp.nanosec / 1e9 for message in messages]
            assert stamps == sorted(stamps)
            assert stamps[-1] == pytest.approx(time.time(), abs=1.0)
        assert heard["odom"].messages[-1].child_frame_id == "base_link"
        assert heard["ground_truth"].messages[-1].child_frame_id == "base_link"
        assert near(heard["odom"].messages[-1], Pose())
        assert near(heard["ground_truth"].messages[-1], Pose(-1.5))
        marker = heard["detected_dock_pose"].messages[-1].pose
        assert (marker.position.x, marker.position.y) == (pytest.approx(1.5, abs=0.06), pytest.approx(0.0, abs=0.06))
        reading = heard["infrared/center"].messages[-1]
        assert (reading.radiation_type, reading.field_of_view) == (Range.INFRARED, 0.5)
        assert reading.range == pytest.approx(1.35, abs=0.06)
        assert heard["infrared/left"].messages[-1].range == math.inf


def test_the_battery_has_every_field(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        state = observer.record(BatteryState, "battery_status").wait_for(lambda _: True)
    assert state.power_supply_status == DISCHARGING
    assert state.percentage == pytest.approx(0.24, abs=0.001)
    assert state.charge == pytest.approx(state.percentage * state.capacity, rel=1e-3)
    assert state.current < 0.0
    assert math.fsum(state.cell_voltage) == pytest.approx(state.voltage, rel=1e-3)
    assert len(state.cell_voltage) == len(state.cell_temperature) == 7
    assert state.present
    assert (state.power_supply_health, state.power_supply_technology) == (1, 1)
    for field in ("temperature", "capacity", "design_capacity"):
        assert math.isfinite(getattr(state, field))


def test_it_drives_by_cmd_vel_and_stops_when_nothing_more_comes(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        truth, odom = observer.record(Odometry, "ground_truth"), observer.record(Odometry, "odom")
        with observer.publishing(velocity(0.2, 0.3), "cmd_vel"):
            truth.wait_for(lambda message: message.twist.twist.linear.x == pytest.approx(0.2))
            odom.wait_for(lambda message: message.twist.twist.linear.x == pytest.approx(0.2, rel=0.05))
        silent_at = time.monotonic()
        wait_until(lambda: not moving(truth.messages[-1]), "a standstill")
        assert time.monotonic() - silent_at > 0.3
        assert pose_of(truth.messages[-1]).distance_to(START) > 0.05


def test_a_latched_stop_holds_it_until_it_is_released(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        truth = observer.record(Odometry, "ground_truth")
        with observer.publishing(velocity(0.2), "cmd_vel"):
            truth.wait_for(moving)
            observer.publish(Bool(data=True), "stop_latched", LATCHED)
            wait_until(lambda: not moving(truth.messages[-1]), "a standstill")
            controls.wait_for_status(halted="true")
            standing = len(truth.messages)
            time.sleep(1.0)
            assert not any(moving(message) for message in truth.messages[standing:])
            controls.reset()
            controls.wait_for_status(halted="true")
            observer.publish(Bool(data=False), "stop_latched", LATCHED)
            wait_for_new(truth, moving)


def test_a_stop_that_was_latched_before_it_started_counts(domain: int, observer: Observer) -> None:
    publisher = observer.call(lambda: observer.node.create_publisher(Bool, "stop_latched", LATCHED))
    observer.call(lambda: publisher.publish(Bool(data=True)))
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        controls.wait_for_status(halted="true")
        truth = observer.record(Odometry, "ground_truth")
        with observer.publishing(velocity(0.2), "cmd_vel"):
            truth.wait_for(lambda _: True)
            time.sleep(1.0)
        assert not any(moving(message) for message in truth.messages)


def test_a_full_battery_is_full_at_once(domain: int, observer: Observer) -> None:
    with dock_simulator(domain, "battery_start:=1.0", "start_x:=-0.2", "start_y:=0.0", "start_theta:=0.0"):
        battery = observer.record(BatteryState, "battery_status")
        full = battery.wait_for(lambda state: state.power_supply_status == FULL)
        assert (full.percentage, full.current) == (1.0, 0.0)


def test_it_is_placed_in_world_only(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        truth, odom = observer.record(Odometry, "ground_truth"), observer.record(Odometry, "odom")
        truth.wait_for(lambda message: near(message, START))
        controls.place(Pose(-1.0, -0.5, 1.0))
        wait_for_new(truth, lambda message: near(message, Pose(-1.0, -0.5, 1.0)))
        controls.place(Pose(-2.0, 0.0, 0.0), frame="odom")
        controls.place(Pose(math.nan, 0.0, 0.0))
        controls.place(Pose(-0.9, -0.5, 1.0))
        wait_for_new(truth, lambda message: near(message, Pose(-0.9, -0.5, 1.0)))
        assert not any(near(message, Pose(-2.0, 0.0, 0.0)) for message in truth.messages)
        assert all(near(message, Pose()) for message in odom.messages), "odometry does not notice"


def test_it_steps_back_for_another_battery_and_resumes(domain: int, observer: Observer) -> None:
    with dock_simulator(domain, "battery_resume_after:=1.5"):
        controls = SimulatorControls(observer)
        battery = observer.record(BatteryState, "battery_status")
        battery.wait_for(lambda state: state.location == "dock_simulator")
        controls.wait_for_status(battery_publisher="self")
        with observer.publishing(LOW, "battery_status", period=1.0):
            controls.wait_for_status(battery_publisher="other")
            time.sleep(0.3)  # what was under way
            before = len(battery.messages)
            time.sleep(3.0)
            heard = battery.messages[before:]
            assert len(heard) >= 2
            assert {state.location for state in heard} == {LOW.location}
        wait_for_new(battery, lambda state: state.location == "dock_simulator")
        controls.wait_for_status(battery_publisher="self")


def test_a_publisher_that_says_nothing_does_not_silence_it(domain: int, observer: Observer) -> None:
    observer.call(lambda: observer.node.create_publisher(BatteryState, "battery_status", 10))
    with dock_simulator(domain):
        battery = observer.record(BatteryState, "battery_status")
        battery.wait_for(lambda state: state.location == "dock_simulator")
        wait_for_new(battery)


def test_stamps_that_stand_still_do_not_make_others_its_own(domain: int, observer: Observer) -> None:
    """With use_sim_time and no /clock every stamp is zero, as in a message typed by hand."""
    with dock_simulator(domain, "use_sim_time:=true"):
        controls = SimulatorControls(observer)
        observer.record(BatteryState, "battery_status").wait_for(lambda state: state.location == "dock_simulator")
        time.sleep(0.5)
        controls.wait_for_status(battery_publisher="self")
        with observer.publishing(LOW, "battery_status"):
            controls.wait_for_status(battery_publisher="other")


def test_time_can_pass_faster(domain: int, observer: Observer) -> None:
    with dock_simulator(domain, "real_time_factor:=3.0"):
        truth = observer.record(Odometry, "ground_truth")
        with observer.publishing(velocity(0.1), "cmd_vel", period=0.05):
            first = truth.wait_for(lambda message: message.twist.twist.linear.x == pytest.approx(0.1))
            began = time.monotonic()
            start = len(truth.messages)
            time.sleep(1.5)
            way = pose_of(truth.messages[-1]).distance_to(pose_of(truth.messages[start - 1]))
            seconds = time.monotonic() - began
        assert way / seconds == pytest.approx(0.3, rel=0.2)
        assert first.twist.twist.linear.x == pytest.approx(0.1)


def test_parameters_are_guarded_and_count_at_once_or_from_the_next_reset_on(domain: int, observer: Observer) -> None:
    with dock_simulator(domain):
        controls = SimulatorControls(observer)
        truth = observer.record(Odometry, "ground_truth")
        assert "out of range" in controls.set_parameter("real_time_factor", -1.0)
        controls.wait_for_status(real_time_factor="1")
        assert controls.set_parameter("real_time_factor", 2.5) == ""
        controls.wait_for_status(real_time_factor="2.5")
        assert controls.set_parameter("start_x", -2.0) == ""
        wait_for_new(truth)
        assert near(truth.messages[-1], START)
        controls.reset()
        wait_for_new(truth, lambda message: near(message, Pose(-2.0, START.y, START.theta)))


def test_robots_are_apart_by_their_namespaces(domain: int, observer: Observer) -> None:
    programs = [
        ForkedProcess("dock_simulator", "--ros-args", "-r", f"__ns:={namespace}", env=ros_environment(domain))
        for namespace in ("/robot1", "/robot2")
    ]
    with programs[0], programs[1]:
        first, second = SimulatorControls(observer, "/robot1"), SimulatorControls(observer, "/robot2")
        first.switch("dead_charger")
        first.wait_for_status(dead_charger="true")
        second.wait_for_status(dead_charger="false")
        truth = [observer.record(Odometry, f"/robot{number}/ground_truth") for number in (1, 2)]
        with observer.publishing(velocity(0.2), "/robot1/cmd_vel"):
            truth[0].wait_for(moving)
        truth[1].wait_for(lambda _: True)
        assert not any(moving(message) for message in truth[1].messages)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_at_once(domain: int, observer: Observer, number: signal.Signals) -> None:
    with Process("dock_simulator", env=ros_environment(domain)) as program:
        observer.record(Odometry, "odom").wait_for(lambda _: True)
        program.send_signal(number)
        assert program.wait() == 0
        assert "Traceback" not in program.output


@pytest.mark.parametrize(
    ("parameter", "complaint"),
    [("slip:=2.0", "slip out of range"), ("real_time_factor:=0.0", "out of range"), ("seed:=1.5", "INTEGER")],
)
def test_a_wrong_parameter_is_refused_in_one_line(domain: int, parameter: str, complaint: str) -> None:
    with ForkedProcess("dock_simulator", "--ros-args", "-p", parameter, env=ros_environment(domain)) as program:
        assert program.wait() == 2
        assert complaint in program.output
        assert len(program.own_lines) == 1
