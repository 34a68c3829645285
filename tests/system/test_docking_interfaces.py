"""Docking a robot whose topics are not those of the tutorial."""

import pytest
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from tests.support.docking import (
    ABORTED,
    CANCELED,
    FAST,
    SERVER,
    SUCCEEDED,
    UNMEASURED,
    Reports,
    docking_servers,
    send_dock_goal,
    send_undock_goal,
)
from tests.support.gateway import running_gateway
from tests.support.observer import Observer, ros_observer
from tests.support.simulator import SimulatorControls, dock_simulator, moving
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

NEAR = "start_x:=-1.2", "start_y:=0.0", "start_theta:=0.0"
DRIVE = "controller:=dock_pose"
STAMPED = "geometry_msgs/msg/TwistStamped"
STOP, GO = Bool(data=True), Bool(data=False)


def published_by(observer: Observer, node: str) -> set[str]:
    """The types of a node's publishers of cmd_vel, as far as the observer has found them."""
    found = observer.node.get_publishers_info_by_topic("cmd_vel")
    return {info.topic_type for info in found if info.node_name == node}


def test_a_base_that_takes_stamped_velocities_docks_and_is_stopped(domain: int, observer: Observer) -> None:
    stamped = observer.record(TwistStamped, "cmd_vel")
    truth = observer.record(Odometry, "ground_truth")
    with dock_simulator(domain, *NEAR, "enable_stamped_cmd_vel:=true"), docking_servers(domain, DRIVE):
        wait_until(lambda: published_by(observer, SERVER[1:]) == {STAMPED}, "stamped velocities")
        assert send_dock_goal(observer).result().status == SUCCEEDED
        stamped.wait_for(lambda message: message.twist.linear.x > 0 and message.header.frame_id == "base_link")
        wait_until(lambda: not moving(truth.messages[-1]), "a standstill")

        with running_gateway(domain) as gateway:
            gateway.wait_until_ready()
            # Its zero velocity reaches only whom DDS has connected by then.
            wait_until(lambda: published_by(observer, "dock_gateway") == {STAMPED}, "the gateway's publisher")
            undocking = send_undock_goal(observer)
            stamped.wait_for(lambda message: message.twist.linear.x < 0)
            with gateway.stream("?include=cmd_vel") as stream:
                stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["linear"]["x"] < 0)
                gateway.http.post("/stop").raise_for_status()
                stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["linear"]["x"] == 0)
            undocking.result()
            # The gateway's own zero, not only the servers'.
            stamped.wait_for(lambda message: message.header.frame_id == "")


def test_a_base_that_hears_nothing_is_a_warning(domain: int, observer: Observer) -> None:
    observer.record(TwistStamped, "cmd_vel")
    with docking_servers(domain, "enable_stamped_cmd_vel:=false"):
        reports = Reports(observer)

        def warned() -> bool:
            return any("/observer as geometry_msgs/msg/TwistStamped" in report["message"] for report in reports.all)

        wait_until(warned, "a warning")


def test_emergency_stops_of_others_hold_the_robot(domain: int, observer: Observer) -> None:
    base = SimulatorControls(observer)
    with (
        dock_simulator(domain, *NEAR, "stop_topics:=e_stop"),
        docking_servers(domain, DRIVE, "stop_topics:=e_stop"),
        running_gateway(domain, emergency_stop_topics="e_stop") as gateway,
        ros_observer(domain, "scanner") as scanner,
        scanner.publishing(GO, "stop_latched"),
    ):
        gateway.wait_until_ready()
        # Discovered before the publisher of e_stop: who hears that one hears the only message of this one, too.
        observer.publish(GO, "stop_latched")
        with observer.publishing(STOP, "e_stop"):
            base.wait_for_status(halted="true")
            wait_until(lambda: gateway.http.get("/stop").json()["by"] == "/observer", "the gateway to obey")
            assert not send_dock_goal(observer).accepted
            refused = gateway.http.delete("/stop")
            assert (refused.status_code, refused.json()["code"]) == (409, "stop_latched")
            assert "/observer" in refused.json()["detail"]
        with observer.publishing(GO, "e_stop"):
            base.wait_for_status(halted="false")
            wait_until(lambda: not gateway.http.get("/stop").json()["latched"], "the gateway to go on")
            goal = send_dock_goal(observer)
            assert goal.accepted
            observer.publish(STOP, "stop_latched")  # volatile, and only once
            # By its server, or by the gateway if that is quicker.
            assert goal.result().status in {ABORTED, CANCELED}
            base.wait_for_status(halted="true")
            wait_until(lambda: gateway.http.get("/stop").json()["latched"], "the gateway to obey")


def test_a_battery_that_tells_only_its_current_docks_and_undocks(domain: int, observer: Observer) -> None:
    battery = "battery_reports_status:=false", "battery_charges_negative:=true"
    source = "charging_source:=current", "charging_current_negative:=true"
    with dock_simulator(domain, *NEAR, FAST, *battery), docking_servers(domain, DRIVE, UNMEASURED, *source):
        result = send_dock_goal(observer).result()
        assert result.status == SUCCEEDED
        assert result.result.final_battery_state.power_supply_status == 0
        assert result.result.final_battery_state.current < -1.0
        assert send_undock_goal(observer).result().status == SUCCEEDED
        SimulatorControls(observer).wait_for_status(contact="false")


def test_the_status_is_told_before_and_after(domain: int, observer: Observer) -> None:
    controls = SimulatorControls(observer)
    with dock_simulator(domain), observer.publishing(STOP, "stop_latched"):
        controls.wait_for_status(halted="true")
