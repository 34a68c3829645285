"""The docking action server is stopped: by a latched stop, and by its watchdog, over DDS."""

import threading
import time

import pytest
from rcl_interfaces.msg import Log
from std_msgs.msg import Bool

from docking.core.observation import Observation, Velocity
from docking.goal.plan import SingleStage
from robot_io.qos import LATCHED
from tests.support.docking import ABORTED, LOW, Reports, dock_server, send_dock_goal, watch_wheels
from tests.support.observer import Observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

BATTERY = "battery_status"


def test_a_latched_stop_aborts_the_goal_and_lets_in_no_other(domain: int, observer: Observer) -> None:
    with dock_server(domain):
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            observer.publish(Bool(data=True), "stop_latched", LATCHED)
            assert goal.result().status == ABORTED
            wait_until(lambda: wheels.standing, "zero velocity")
            reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="STOP_LATCHED", error_number="953")
            refused = send_dock_goal(observer)
            assert not refused.accepted
            reports.wait_for(goal_id=refused.goal_id, stage="REJECTED", error_code="STOP_LATCHED")
            observer.publish(Bool(data=False), "stop_latched", LATCHED)
            wait_until(lambda: send_dock_goal(observer).accepted, "the release")
            wait_until(lambda: wheels.moving, "a move after the release")


def test_a_stop_that_was_latched_before_the_server_came_counts(domain: int, observer: Observer) -> None:
    publisher = observer.call(lambda: observer.node.create_publisher(Bool, "stop_latched", LATCHED))
    observer.call(lambda: publisher.publish(Bool(data=True)))
    with dock_server(domain):
        wait_until(publisher.get_subscription_count, "the server's subscription")
        wait_until(lambda: not send_dock_goal(observer).accepted, "a rejection")


class Hangs:
    """A controller that drives faster at each step, and takes too long for the fifth."""

    def __init__(self) -> None:
        self.speed = 0.0
        self.hung_at = 0.0
        self.hanging = threading.Event()
        self.go_on = threading.Event()

    def step(self, _observation: Observation, _dt: float) -> Velocity:
        self.speed += 0.01
        if self.speed == pytest.approx(0.05):
            self.hung_at = time.monotonic()
            self.hanging.set()
            assert self.go_on.wait(30)
        return Velocity(self.speed, 0.0)


def test_the_watchdog_stops_a_robot_whose_controller_hangs(domain: int, observer: Observer) -> None:
    controller = Hangs()
    with dock_server(domain, make_plan=lambda _settings: SingleStage(controller)):
        wheels = watch_wheels(observer)
        log = observer.record(Log, "/rosout")
        with observer.publishing(LOW, BATTERY):
            goal = send_dock_goal(observer)
            assert controller.hanging.wait(15)
            try:
                wait_until(lambda: wheels.standing, "zero velocity")
                took = time.monotonic() - controller.hung_at
                before = len(wheels.messages)
            finally:
                controller.go_on.set()
            assert took > 0.3
            wait_until(lambda: wheels.moving, "a move when it is over")
            speeds = [message.linear.x for message in wheels.messages]
            assert [speed for speed in speeds[:before] if speed][-1] == pytest.approx(0.04)
            assert 0.05 not in [round(speed, 3) for speed in speeds], "what was decided on long ago moves nothing"
            log.wait_for(lambda entry: "No control step for 0.5 s" in entry.msg)
            assert goal.cancel()
