"""Staging by nav2's `navigate_to_pose`: it drives the robot to its staging pose, and is stopped with every goal."""

import math
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool

from docking.core.geometry import Pose
from docking.ros import navigation
from docking.simulation.dock import DOCKED
from robot_io.qos import LATCHED
from tests.support.docking import (
    ABORTED,
    CANCELED,
    FAST,
    SERVER,
    SUCCEEDED,
    UNMEASURED,
    docking_servers,
    send_dock_goal,
)
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import Site, assert_docked, look_at
from tests.support.waiting import wait_until

pytest.importorskip("nav2_msgs.action", reason="`make test` installs the interface packages of tests/interfaces")

from tests.support.navigation import MARK, Nav2, nav2

pytestmark = pytest.mark.ros

FAR = Pose(-4.8, 0.8, 2.0)
"""A start from which the dock is not seen, 4 m from the staging pose."""
BY_ODOMETRY = DOCKED.relative_to(FAR)
STAGING = DOCKED.compose(Pose(-0.7))
LEFT_TO_NAV2 = "publish_map:=false"
DATABASE = (
    "controller:=dock_pose",
    "navigate_to_staging_pose:=true",
    "docks:=[home, yard]",
    "home.frame:=map",
    f"home.pose:=[{DOCKED.x}, {DOCKED.y}, {DOCKED.theta}]",
    "yard.frame:=odom",
    f"yard.pose:=[{BY_ODOMETRY.x}, {BY_ODOMETRY.y}, {BY_ODOMETRY.theta}]",
)


def driven_by_us(site: Site) -> int:
    """How many velocities other than zero the docking server has published."""
    return sum(1 for message in site.wheels.messages if message.linear.z != MARK and message != Twist())


def expect_both_zeros(site: Site, since: int) -> None:
    """Wait until nav2 has published its one zero velocity, and the docking server its own."""

    def both() -> bool:
        zeros = [message for message in site.wheels.messages[since:] if message == Twist()]
        of_nav2 = sum(1 for zero in zeros if math.copysign(1.0, zero.linear.z) < 0.0)
        return of_nav2 == 1 and len(zeros) > 1

    wait_until(both, "both zero velocities")


@contextmanager
def robot(domain: int, *parameters: str) -> Iterator[Nav2]:
    """A simulated robot far from its dock, and nav2."""
    place = f"start_x:={FAR.x}", f"start_y:={FAR.y}", f"start_theta:={FAR.theta}", "linear_max:=1.0"
    with dock_simulator(domain, *place, LEFT_TO_NAV2, *parameters), nav2(domain, FAR) as server:
        yield server


def test_a_robot_far_from_its_dock_is_driven_to_the_staging_pose_and_docks(domain: int, observer: Observer) -> None:
    with (
        robot(domain, FAST) as server,
        docking_servers(domain, *DATABASE, UNMEASURED, "navigator_bt_xml:=slowly.xml"),
    ):
        site = look_at(observer)
        goal = send_dock_goal(observer, dock="home")
        site.wait_for_stage(goal, "NAV_TO_STAGING_POSE")
        wait_until(lambda: server.ends, "the end of the navigation", 60.0)
        assert server.trees == ["slowly.xml"]
        assert driven_by_us(site) == 0
        assert (server.ends, [frame for frame, _ in server.poses]) == (["succeeded"], ["map"])
        assert server.poses[0][1].distance_to(STAGING) < 0.01
        assert site.pose.distance_to(STAGING) < 0.3
        assert goal.result(120.0).status == SUCCEEDED
        stages = [report["stage"] for report in site.reports.all if report.get("goal_id") == goal.goal_id]
        assert stages.index("NAV_TO_STAGING_POSE") < stages.index("INITIAL_PERCEPTION") < stages.index("CONTROLLING")
        site.expect_standstill()
        assert_docked(site.pose)
        assert len(goal.feedback) > 10

        # Docked, it is near enough: nobody navigates.
        assert send_dock_goal(observer, dock="home").result().status == SUCCEEDED
        assert len(server.poses) == 1


def test_each_end_of_a_goal_stops_nav2_and_each_end_of_nav2_the_goal(domain: int, observer: Observer) -> None:
    with robot(domain) as server:
        with docking_servers(domain, *DATABASE):
            site = look_at(observer)

            def ends(number: int, how: str) -> None:
                wait_until(lambda: len(server.ends) == number, "the end of the navigation")
                assert server.ends[-1] == how
                site.expect_standstill()

            def driving() -> bool:
                return server.driving and not site.stands

            goal = send_dock_goal(observer)
            wait_until(driving, "nav2 to drive")
            moving = len(site.wheels.messages)
            assert goal.cancel()
            assert goal.result().status == CANCELED
            ends(1, "canceled")
            expect_both_zeros(site, moving)

            server.gives_up = True
            site.expect_abort(send_dock_goal(observer), "FAILED_TO_STAGE", 30.0)
            report = site.reports.wait_for(stage="ABORTED", error_number="903")
            assert report["error_msg"] == "/navigate_to_pose aborted the goal: no valid path found, error_code 208"
            ends(2, "aborted")

            server.gives_up, server.rejects = False, True
            rejected = site.expect_abort(send_dock_goal(observer), "FAILED_TO_STAGE", 30.0)
            assert rejected["error_msg"] == "/navigate_to_pose rejected the staging pose"

            server.rejects = False
            goal = send_dock_goal(observer)
            wait_until(driving, "nav2 to drive")
            moving = len(site.wheels.messages)
            site.controls.switch("silent_battery")
            site.wait_for_stage(goal, "WAIT_FOR_BATTERY")
            ends(3, "canceled")
            expect_both_zeros(site, moving)
            site.controls.switch("silent_battery", False)
            wait_until(driving, "nav2 to drive again")

            observer.publish(Bool(data=True), "stop_latched", LATCHED)
            assert goal.result().status == ABORTED
            ends(4, "canceled")
            observer.publish(Bool(data=False), "stop_latched", LATCHED)

            def accepted() -> bool:
                return send_dock_goal(observer, dock="yard").accepted

            wait_until(accepted, "the stop to be released")
            wait_until(driving, "nav2 to drive")
            assert server.poses[-1][0] == "odom"
            assert server.poses[-1][1].distance_to(STAGING.relative_to(FAR)) < 0.01
        # The server has ended.
        wait_until(lambda: len(server.ends) == 5, "the end of the navigation")
        assert server.ends[-1] == "canceled"
        assert driven_by_us(site) == 0


def test_nav2_is_stopped_also_if_it_answers_after_the_goal_and_is_not_wanted_any_more(
    domain: int, observer: Observer
) -> None:
    with robot(domain) as server, docking_servers(domain, *DATABASE):
        site = look_at(observer)
        server.answers.clear()
        goal = send_dock_goal(observer)
        wait_until(lambda: server.asked == 1, "a request to nav2")
        assert observer.set_parameter(SERVER, "navigate_to_staging_pose", False) == ""
        goal.cancel()
        assert goal.result().status in {CANCELED, ABORTED}
        server.answers.set()
        wait_until(lambda: server.ends == ["canceled"], "the end of the navigation")
        site.expect_standstill()


@pytest.mark.parametrize("installed", [True, False])
def test_without_nav2_the_robot_searches_from_where_it_is(
    domain: int,
    observer: Observer,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    installed: bool,
) -> None:
    if not installed:
        monkeypatch.setattr(navigation, "NavigateToPose", None)
    reason = "there is no action server /navigate_to_pose" if installed else "nav2_msgs is not installed"
    with dock_simulator(domain, LEFT_TO_NAV2), docking_servers(domain, *DATABASE):
        site = look_at(observer)
        goal = send_dock_goal(observer)
        site.wait_for_stage(goal, "INITIAL_PERCEPTION")
        assert goal.cancel()
        assert goal.result().status == CANCELED
    log = capfd.readouterr().err
    assert log.count(f"before the dock is looked for: {reason}") == 1, log
