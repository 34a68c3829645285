"""An omnidirectional base over DDS: it is commanded sideways, and odometry and the simulated base follow."""

import pytest
from geometry_msgs.msg import Twist

from docking.core.geometry import Pose
from tests.support.docking import SUCCEEDED, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import assert_docked, look_at

pytestmark = pytest.mark.ros

START = Pose(-0.5, 0.02, 0.0)
"""At the staging pose, a little to the left."""
WORLD = (f"start_x:={START.x}", f"start_y:={START.y}", f"start_theta:={START.theta}", "omnidirectional:=true")


def test_an_omnidirectional_base_corrects_its_lateral_error_sideways(domain: int, observer: Observer) -> None:
    server = ("controller:=dock_pose", "motion_model:=Omni", "staging_x_offset:=-0.3")
    with dock_simulator(domain, *WORLD), docking_servers(domain, *server):
        here = look_at(observer)
        commands = observer.record(Twist, "cmd_vel")
        goal = send_dock_goal(observer)
        assert goal.result(60.0).status == SUCCEEDED
        assert_docked(here.pose)
        assert any(message.linear.y < 0.0 for message in commands.messages), "to the right, where the dock is"
        assert any(message.twist.twist.linear.y < 0.0 for message in here.truth.messages)
