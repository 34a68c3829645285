"""The docking action server over DDS."""

import math
import threading
import time

import pytest
from action_msgs.srv import CancelGoal
from geometry_msgs.msg import Twist
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Log, ParameterType, ParameterValue
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import BatteryState
from unique_identifier_msgs.msg import UUID

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.core.observation import Observation, Velocity
from docking.core.parameter import parameters_of
from docking.goal.plan import SingleStage
from docking.parameters import DockSettings
from robot_io.rclpy_private import RESULT_TIMEOUT
from tests.support.docking import (
    ABORTED,
    ACTION,
    CANCELED,
    CHARGING,
    LOW,
    SERVER,
    SUCCEEDED,
    Reports,
    dock_goal,
    dock_server,
    send_dock_goal,
    watch_wheels,
)
from tests.support.observer import Observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

BATTERY = "battery_status"


def test_it_drives_until_the_battery_is_charging(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        wheels = watch_wheels(observer)
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            assert goal.accepted
            wait_until(lambda: len(wheels.messages) > 5 and len(goal.feedback) > 5, "ten messages a second")
        assert {(message.linear.x, message.angular.z) for message in wheels.messages[1:]} == {(0.0, 0.15)}
        observer.publish(CHARGING, BATTERY)
        answer = goal.result()
        assert answer.status == SUCCEEDED
        final = answer.result.final_battery_state
        assert (final.power_supply_status, final.voltage, final.percentage) == (
            1,
            pytest.approx(2.16),
            pytest.approx(0.24),
        )
        wait_until(lambda: goal.feedback[-1].current_battery_state == final, "a last feedback")
        wait_until(lambda: wheels.standing, "zero velocity")
        assert wheels.messages.count(Twist()) <= 2  # one before the first battery message, if the goal was faster


def test_a_battery_that_is_charging_already_ends_the_goal_without_a_move(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        wheels = watch_wheels(observer)
        with observer.publishing(CHARGING, BATTERY):
            assert send_dock_goal(observer, status=0).result().status == SUCCEEDED
        assert all(message == Twist() for message in wheels.messages)


def test_cancel_stops_the_robot(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            assert goal.cancel()
            answer = goal.result()
            assert answer.status == CANCELED
            assert answer.result.final_battery_state.power_supply_status == 3
            wait_until(lambda: wheels.standing, "zero velocity")
            reports.wait_for(stage="CANCELED", error_code="NONE", goal_id=goal.goal_id)
            assert not goal.cancel(), "a goal that has ended is not canceled again"


def test_a_second_goal_is_rejected_with_a_reason(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        reports = Reports(observer)
        log = observer.record(Log, "/rosout")
        with observer.publishing(LOW, BATTERY):
            first = send_dock_goal(observer)
            second = send_dock_goal(observer)
            assert (first.accepted, second.accepted) == (True, False)
            report = reports.wait_for(goal_id=second.goal_id)
            assert (report["stage"], report["error_code"], report["level"]) == ("REJECTED", "DOCK_BUSY", 1)
            assert first.goal_id in report["error_msg"]
            log.wait_for(lambda entry: second.goal_id in entry.msg and "DOCK_BUSY" in entry.msg)
            reports.wait_for(stage="CONTROLLING", goal_id=first.goal_id)
        observer.publish(CHARGING, BATTERY)
        assert first.result().status == SUCCEEDED


def test_a_goal_that_docking_cannot_bring_about_is_rejected(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        reports = Reports(observer)
        goal = send_dock_goal(observer, status=200)
        assert not goal.accepted
        assert "200" in reports.wait_for(goal_id=goal.goal_id, error_code="INVALID_GOAL")["error_msg"]


def test_a_second_goal_preempts_where_the_policy_says_so(domain: int, observer: Observer) -> None:
    with dock_server(domain, "goal_policy:=preempt"):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            first = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            moves = len(wheels.messages)
            second = send_dock_goal(observer)
            assert first.result().status == ABORTED
            reports.wait_for(goal_id=first.goal_id, stage="ABORTED", error_code="PREEMPTED")
            wait_until(lambda: Twist() in wheels.messages[moves:], "zero velocity in between")
            wait_until(lambda: wheels.moving, "a move for the second goal")
        observer.publish(CHARGING, BATTERY)
        assert second.result().status == SUCCEEDED
        wait_until(lambda: wheels.standing, "zero velocity")


def test_a_cancel_of_all_goals_reaches_the_one_that_has_just_preempted_another(domain: int, observer: Observer) -> None:
    services, goal_id = ConnectToChargingDock.Impl, UUID(uuid=list(range(16)))
    send = services.SendGoalService.Request(goal_id=goal_id, goal=dock_goal())
    go_on = threading.Event()
    with dock_server(domain, "goal_policy:=preempt") as server:
        first = send_dock_goal(observer)
        try:
            server.executor.create_task(go_on.wait, 15.0)  # then it takes both requests at once
            observer.ask(services.SendGoalService, f"{ACTION}/_action/send_goal", send)
            canceled = observer.ask(CancelGoal, f"{ACTION}/_action/cancel_goal", CancelGoal.Request())
            time.sleep(0.5)
        finally:
            go_on.set()
        answer = observer.result_of(canceled, "the answer to the cancel")
        assert [info.goal_id for info in answer.goals_canceling] == [goal_id]
        assert first.result().status == ABORTED
        get = services.GetResultService.Request(goal_id=goal_id)
        assert observer.request(services.GetResultService, f"{ACTION}/_action/get_result", get).status == CANCELED


def test_a_silent_battery_stops_the_wheels_and_keeps_the_goal(domain: int, observer: Observer) -> None:
    with dock_server(domain, "battery_stale_after:=0.5"):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
        wait_until(lambda: wheels.standing, "zero velocity")
        reports.wait_for(goal_id=goal.goal_id, stage="WAIT_FOR_BATTERY", error_code="BATTERY_STALE")
        assert not goal.ended
        with observer.publishing(LOW, BATTERY):
            wait_until(lambda: wheels.moving, "a move after the silence")
        observer.publish(CHARGING, BATTERY)
        assert goal.result().status == SUCCEEDED


def test_a_lost_battery_aborts_the_goal(domain: int, observer: Observer) -> None:
    with dock_server(domain, "battery_stale_after:=0.3", "battery_lost_after:=0.6"):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        log = observer.record(Log, "/rosout")
        goal = send_dock_goal(observer)
        answer = goal.result()
        assert answer.status == ABORTED
        assert math.isnan(answer.result.final_battery_state.percentage), "no battery was ever heard of"
        reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="BATTERY_LOST")
        log.wait_for(lambda entry: goal.goal_id in entry.msg and "BATTERY_LOST" in entry.msg)
        wait_until(lambda: wheels.standing, "zero velocity")


class RaisesAtFirst:
    """A controller that drives twice and then breaks; the one of the next goal does not."""

    made = 0

    def __init__(self) -> None:
        self.steps = 0
        type(self).made += 1
        self.breaks = self.made == 1

    def step(self, _observation: Observation, _dt: float) -> Velocity:
        self.steps += 1
        if self.breaks and self.steps > 2:
            raise ZeroDivisionError("the dock is nowhere")
        return Velocity(0.1, 0.0)


def test_an_exception_stops_the_robot_and_the_server_goes_on(domain: int, observer: Observer) -> None:
    with dock_server(domain, make_plan=lambda _settings: SingleStage(RaisesAtFirst())):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            assert goal.result().status == ABORTED
            wait_until(lambda: wheels.standing and len(wheels.messages) >= 3, "zero velocity after some moves")
            report = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")
            assert (report["error_code"], report["error_msg"]) == ("UNKNOWN", "ZeroDivisionError: the dock is nowhere")
            second = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move for the second goal")
        observer.publish(CHARGING, BATTERY)
        assert second.result().status == SUCCEEDED


def test_a_sensor_that_cannot_be_subscribed_to_aborts_the_goal(domain: int, observer: Observer) -> None:
    wrong = "qos_overrides./odom.subscription.reliability:=none"
    with dock_server(domain, "controller:=dock_pose", wrong):
        reports = Reports(observer)
        for _ in range(2):
            goal = send_dock_goal(observer)
            assert goal.result().status == ABORTED
            report = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="UNKNOWN")
            assert "reliability" in report["error_msg"]


def test_a_garbage_battery_is_shown_and_does_no_harm(domain: int, observer: Observer) -> None:
    garbage = BatteryState(
        voltage=math.nan,
        percentage=2400.0,
        current=math.inf,
        power_supply_status=250,
        cell_voltage=[math.nan] * 1000,
        location="\N{BATTERY}" * 1000,
    )
    with dock_server(domain):
        with observer.publishing(garbage, BATTERY):
            goal = send_dock_goal(observer)
            wait_until(
                lambda: goal.feedback and goal.feedback[-1].current_battery_state.percentage == 2400.0, "feedback"
            )
            assert goal.feedback[-1].current_battery_state.power_supply_status == 250
        observer.publish(CHARGING, BATTERY)
        assert goal.result().status == SUCCEEDED


def test_a_percentage_that_is_none_is_told(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        reports = Reports(observer)
        with observer.publishing(BatteryState(percentage=24.0, power_supply_status=3), BATTERY):
            complaint = "/battery_status has a percentage of 24, but it must be from 0 to 1"
            report = reports.wait_for(name="connect_to_charging_dock_action_server: sensors", level=1)
            assert report["message"] == report["/battery_status"] == complaint
        with observer.publishing(LOW, BATTERY):
            wait_until(lambda: reports.all[-1]["message"] == "ok", "a report that all is well")


def test_the_report_is_repeated_while_nothing_happens(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        reports = Reports(observer)
        name = "connect_to_charging_dock_action_server: "
        wait_until(lambda: len(reports.all) >= 4, "two reports on goals and sensors")
        assert reports.all[-1] == {"level": 0, "name": f"{name}sensors", "message": "ok"}
        assert reports.all[-2] == {
            "level": 0,
            "name": f"{name}connect_to_charging_dock",
            "message": "idle",
            "stage": "IDLE",
            "error_code": "NONE",
            "error_msg": "",
            "goal_id": "",
            "error_number": "0",
            "retries": "0",
            "doubts": "",
        }


def test_parameters_are_described_and_guarded(domain: int, observer: Observer) -> None:
    parameters = list(parameters_of(DockSettings))
    names = [parameter.name for parameter in parameters]
    with dock_server(domain) as server:
        request = DescribeParameters.Request(names=names)
        descriptors = observer.request(DescribeParameters, f"{SERVER}/describe_parameters", request).descriptors
        for parameter, descriptor in zip(parameters, descriptors, strict=True):
            assert descriptor.description == parameter.text
            if descriptor.type == ParameterType.PARAMETER_DOUBLE:
                assert descriptor.floating_point_range[0].to_value == parameter.maximum
        refused = {
            "goal_timeout": -1.0,
            "battery_stale_after": math.nan,
            "rotate_speed": math.inf,
            "battery_lost_after": 1.0,
            "goal_policy": "queue",
            "footprint": "[[0.2, 0.15]]",
        }
        for name, value in refused.items():
            (answer,) = server.set_parameters([Parameter(name, value=value)])
            assert not answer.successful
            assert name in answer.reason


def test_a_changed_parameter_counts_from_the_next_goal(domain: int, observer: Observer) -> None:
    with dock_server(domain) as server:
        wheels = watch_wheels(observer)
        (answer,) = server.set_parameters([Parameter("rotate_speed", value=-0.5)])
        assert answer.successful
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            assert wheels.messages[-1].angular.z == -0.5
            assert goal.cancel()


def test_requests_on_which_rclpy_raises_end_nothing(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        wheels = watch_wheels(observer)
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            again = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_ACTIVATE))
            assert not observer.request(ChangeState, f"{SERVER}/change_state", again).success
            odd = ParameterMessage(name="rotate_speed", value=ParameterValue(type=42))
            request = SetParameters.Request(parameters=[odd])
            assert not observer.request(SetParameters, f"{SERVER}/set_parameters", request).results
            wheels.messages.clear()
            wait_until(lambda: wheels.moving, "the same goal's moves")
            assert goal.cancel()


def test_results_are_not_kept_for_long() -> None:
    assert RESULT_TIMEOUT == 10


def test_a_node_that_is_not_active_lets_no_goal_in(domain: int, observer: Observer) -> None:
    with dock_server(domain, "autostart:=false"):
        wheels, reports = watch_wheels(observer), Reports(observer)

        def change(transition: int) -> bool:
            request = ChangeState.Request(transition=Transition(id=transition))
            return bool(observer.request(ChangeState, f"{SERVER}/change_state", request).success)

        with observer.publishing(LOW, BATTERY):
            refused = send_dock_goal(observer)
            assert not refused.accepted
            reports.wait_for(goal_id=refused.goal_id, error_code="NOT_ACTIVE", error_number="955")
            assert change(Transition.TRANSITION_CONFIGURE)
            assert not send_dock_goal(observer).accepted
            assert change(Transition.TRANSITION_ACTIVATE)
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            assert change(Transition.TRANSITION_DEACTIVATE)
            assert goal.result().status == ABORTED
            reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="NOT_ACTIVE")
            wait_until(lambda: wheels.standing, "zero velocity")
            assert not send_dock_goal(observer).accepted
