"""Drives backwards."""

import math
from dataclasses import replace

from docking.core.geometry import Pose
from docking.core.observation import Observation, Velocity
from docking.goal.behavior import Behavior, Step

TURNED = Pose(theta=math.pi)


class Reversed:
    """Lets a behavior drive the robot as if its back were its front."""

    def __init__(self, behavior: Behavior) -> None:
        self._behavior = behavior

    def step(self, observation: Observation, dt: float) -> Step:
        """What the behavior would do with a robot that is turned round, the other way."""
        odometry = observation.odometry
        if odometry is not None:
            velocity = Velocity(-odometry.velocity.linear_x, odometry.velocity.angular_z)
            turned = replace(odometry, pose=odometry.pose.compose(TURNED), velocity=velocity)
            observation = replace(observation, odometry=turned)
        step = self._behavior.step(observation, dt)
        return Velocity(-step.linear_x, step.angular_z) if isinstance(step, Velocity) else step
