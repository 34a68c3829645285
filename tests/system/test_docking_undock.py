"""Undocking over DDS, and docking and undocking in one process."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool

from docking.core.geometry import Pose
from robot_io.qos import LATCHED
from tests.support.docking import (
    ABORTED,
    CANCELED,
    CHARGING,
    LOW,
    Reports,
    docking_servers,
    send_dock_goal,
    send_undock_goal,
    watch_wheels,
)
from tests.support.observer import GoalOfTest, Observer
from tests.support.processes import ForkedProcess, client_process, ros_environment
from tests.support.sensors import odometry
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

BATTERY = "battery_status"
PROGRAM = "docking_server"
# A robot that does not move is blocked only after this, on a busy machine, too: what the test is about comes first.
HELD = "blocked_after:=60.0"
UNDOCK_NODE = "disconnect_from_charging_dock_action_server"


@contextmanager
def on_the_dock(observer: Observer, namespace: str = "") -> Iterator[None]:
    """A robot that charges, and whose odometry says that it stands still, whatever it is told."""
    with (
        observer.publishing(CHARGING, f"{namespace}{BATTERY}"),
        observer.publishing(odometry(Pose(), 1.0), f"{namespace}odom", heard=False),
    ):
        yield


def test_where_nothing_tells_that_the_robot_is_docked_it_does_not_move(domain: int, observer: Observer) -> None:
    with docking_servers(domain):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            for status in (0, 2, 3):
                goal = send_undock_goal(observer, status)
                answer = goal.result()
                assert answer.status == ABORTED
                assert answer.result.final_battery_state.power_supply_status == 3
                report = reports.wait_for(goal_id=goal.goal_id, error_code="DOCKED_UNKNOWN", error_number="973")
                assert "3 (NOT_CHARGING)" in report["error_msg"]
        assert all(message == Twist() for message in wheels.messages)


def test_a_goal_that_undocking_cannot_bring_about_is_rejected(domain: int, observer: Observer) -> None:
    with docking_servers(domain):
        reports = Reports(observer)
        goal = send_undock_goal(observer, 1)
        assert not goal.accepted
        assert "1 (CHARGING)" in reports.wait_for(goal_id=goal.goal_id, error_code="INVALID_GOAL")["error_msg"]


def test_it_backs_out_with_feedback_and_ends_when_the_robot_does_not_move(domain: int, observer: Observer) -> None:
    with docking_servers(domain, "blocked_after:=1.0"):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with on_the_dock(observer):
            goal = send_undock_goal(observer)
            reports.wait_for(
                goal_id=goal.goal_id, stage="UNDOCKING", name=f"{UNDOCK_NODE}: disconnect_from_charging_dock"
            )
            wait_until(lambda: wheels.moving, "a move")
            assert wheels.messages[-1].linear.x < 0.0
            answer = goal.result()
            assert answer.status == ABORTED
            assert answer.result.final_battery_state.power_supply_status == 1
            reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="FAILED_TO_UNDOCK", error_number="972")
            wait_until(lambda: wheels.standing, "zero velocity")
        assert len(goal.feedback) >= 8
        assert {feedback.current_battery_state.power_supply_status for feedback in goal.feedback} <= {0, 1}


def test_nothing_moves_without_odometry(domain: int, observer: Observer) -> None:
    with docking_servers(domain, "odometry_timeout:=2.0"):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(CHARGING, BATTERY):
            goal = send_undock_goal(observer)
            reports.wait_for(goal_id=goal.goal_id, stage="WAIT_FOR_ODOMETRY", error_code="ODOMETRY_LOST")
            assert goal.result().status == ABORTED
        reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="ODOMETRY_LOST")
        assert all(message == Twist() for message in wheels.messages)


def test_one_goal_at_a_time_over_both_actions(domain: int, observer: Observer) -> None:
    with docking_servers(domain, HELD):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            docking = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            refused = send_undock_goal(observer)
            assert (docking.accepted, refused.accepted) == (True, False)
            report = reports.wait_for(goal_id=refused.goal_id, error_code="DOCK_BUSY")
            assert docking.goal_id in report["error_msg"]
            assert docking.cancel()
            assert docking.result().status == CANCELED
        with on_the_dock(observer):
            undocking = send_undock_goal(observer)
            refused = send_dock_goal(observer)
            assert (undocking.accepted, refused.accepted) == (True, False)
            report = reports.wait_for(goal_id=refused.goal_id, error_code="DOCK_BUSY")
            assert undocking.goal_id in report["error_msg"]


def test_undocking_preempts_docking_where_the_policy_says_so(domain: int, observer: Observer) -> None:
    with docking_servers(domain, "goal_policy:=preempt"):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            docking = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            assert send_undock_goal(observer).result().status == ABORTED
            assert docking.result().status == ABORTED
            reports.wait_for(goal_id=docking.goal_id, stage="ABORTED", error_code="PREEMPTED")
            wait_until(lambda: wheels.standing, "zero velocity")


def test_a_latched_stop_ends_undocking_and_lets_in_nothing(domain: int, observer: Observer) -> None:
    with docking_servers(domain, HELD):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with on_the_dock(observer):
            goal = send_undock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            observer.publish(Bool(data=True), "stop_latched", LATCHED)
            assert goal.result().status == ABORTED
            reports.wait_for(goal_id=goal.goal_id, error_code="STOP_LATCHED")
            wait_until(lambda: wheels.standing, "zero velocity")
            wait_until(lambda: not send_dock_goal(observer).accepted, "a rejected goal to dock")
            assert not send_undock_goal(observer).accepted


@pytest.mark.parametrize("send", [send_dock_goal, send_undock_goal])
def test_a_goal_that_a_stop_cancels_is_canceled_however_late_the_server_hears_of_both(
    domain: int, observer: Observer, monkeypatch: pytest.MonkeyPatch, send: Callable[[Observer], GoalOfTest]
) -> None:
    """A gateway's stop cancels the goals and then latches; a busy server finds both at once."""
    battery = CHARGING if send is send_undock_goal else LOW
    with docking_servers(domain, HELD) as (dock, undock):
        executor = dock.executor
        last = undock if send is send_undock_goal else dock
        # The server without a goal is the first to hear.
        nodes = sorted(executor.get_nodes(), key=lambda node: node is last)
        monkeypatch.setattr(executor, "get_nodes", lambda: nodes)
        wheels = watch_wheels(observer)
        with (
            observer.publishing(battery, BATTERY),
            observer.publishing(odometry(Pose(), 1.0), "odom", heard=False),
        ):
            goal = send(observer)
            wait_until(lambda: wheels.moving, "a move")
            busy = threading.Event()
            executor.create_task(partial(busy.wait, PATIENCE))
            canceled = observer.call(goal.handle.cancel_goal_async)
            observer.publish(Bool(data=True), "stop_latched", LATCHED)
            time.sleep(0.5)  # for both to reach the server
            busy.set()
            assert observer.result_of(canceled, "the answer to the cancel").goals_canceling
            assert goal.result().status == CANCELED
            wait_until(lambda: wheels.standing, "zero velocity")


def test_the_program_holds_both_servers_and_ends_at_a_signal(domain: int, observer: Observer) -> None:
    arguments = ("--ros-args", "-r", "__ns:=/robot1", "-p", "controller:=dock_pose", "-p", HELD)
    with ForkedProcess(PROGRAM, *arguments, env=ros_environment(domain)) as program:
        wheels = watch_wheels(observer, "/robot1/cmd_vel")
        reports = Reports(observer)
        names = {
            "battery_state_subscriber",
            "connect_to_charging_dock_action_server",
            "disconnect_from_charging_dock_action_server",
        }
        wait_until(lambda: names <= set(observer.node.get_node_names()), "three nodes")
        with on_the_dock(observer, "/robot1/"):
            goal = send_undock_goal(observer, action="/robot1/disconnect_from_charging_dock")
            wait_until(lambda: wheels.moving, "a move")
            program.send_signal(signal.SIGTERM)
            answer = goal.result()
            assert program.wait() == 0
        assert answer.status == ABORTED
        assert wheels.standing
        report = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="SHUTTING_DOWN")
        assert report["name"] == f"robot1/{UNDOCK_NODE}: disconnect_from_charging_dock"
        assert "Traceback" not in program.output


def test_the_client_undocks(domain: int, observer: Observer) -> None:
    client = "disconnect_from_charging_dock_client"
    with docking_servers(domain, HELD):
        with observer.publishing(LOW, BATTERY), client_process(domain, client) as process:
            process.wait_for("Goal accepted...")
            process.wait_for("The goal was aborted: it is not known whether the robot is docked")
            assert process.wait() == 1
        with on_the_dock(observer), client_process(domain, client) as process:
            process.wait_for("Received feedback (1 = CHARGING, 3 = NOT CHARGING): 1")
            process.send_signal(signal.SIGINT)
            process.wait_for("The goal was canceled")
            assert process.wait() == 130
        with client_process(domain, client, "--status", "1") as process:
            assert "1 (CHARGING)" in process.wait_for("The goal was rejected: ")
            assert process.wait() == 3
