import math
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from docking.behaviors.combined import Reversed
from docking.core.errors import FailedToControl
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.goal.behavior import Done, Failed, Step

number = st.floats(-3.0, 3.0)
poses = st.builds(Pose, number, number, number)
velocities = st.builds(Velocity, number, number)


class Echo:
    """Keeps what it was given, and says what it was told to."""

    def __init__(self, says: Step) -> None:
        self.says = says
        self.heard: Observation | None = None

    def step(self, observation: Observation, dt: float) -> Step:
        self.heard = observation
        return self.says


def moved(pose: Pose, velocity: Velocity, dt: float) -> Pose:
    """Where a robot is after a short while."""
    return pose.compose(Pose(velocity.linear_x * dt, 0.0, velocity.angular_z * dt))


@given(poses, velocities, velocities)
def test_it_moves_the_robot_as_the_behavior_moves_one_that_is_turned_round(
    pose: Pose, measured: Velocity, wanted: Velocity
) -> None:
    echo = Echo(wanted)
    step = Reversed(echo).step(Observation(1.0, odometry=Odometry(pose, measured, 1.0)), 0.05)
    assert echo.heard is not None
    assert echo.heard.odometry is not None
    turned = echo.heard.odometry
    assert math.isclose(math.cos(turned.pose.theta - pose.theta), -1.0)
    assert isinstance(step, Velocity)
    for robot, mirrored in ((step, wanted), (measured, turned.velocity)):
        there = moved(pose, robot, 0.1).compose(Pose(theta=math.pi))
        assert there.distance_to(moved(turned.pose, mirrored, 0.1)) < 1e-9
    assert replace(echo.heard, odometry=None) == Observation(1.0)


def test_what_is_no_velocity_is_passed_on() -> None:
    failed = Failed(FailedToControl("why"))
    assert Reversed(Echo(failed)).step(Observation(0.0), 0.0) is failed
    assert Reversed(Echo(Done())).step(Observation(0.0), 0.0) == Done()
    assert Reversed(Echo(STANDSTILL)).step(Observation(0.0), 0.0) == STANDSTILL
