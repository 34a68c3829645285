"""The robot: two driven wheels, motors with limits, wheels that slip."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.footprint import ROBOT_RADIUS
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Velocity
from docking.core.parameter import number, switch

ROUNDING = 1e-9
"""Rounding error of sums of many steps, in s."""


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """Properties of the robot.

    Attributes:
        radius: Of its round body, in m.
        wheel_separation: Between the two wheels, in m.
        slip_noise: Grows with the root of the way.
        stall_time: Seconds that a motor bears a wheel that is stuck, until both motors are switched off. They
            come back with the next command to stand still.
    """

    radius: float = ROBOT_RADIUS
    wheel_separation: float = 0.23
    linear_max: float = number(0.3, 0.0, 5.0, "m/s", "Maximum linear velocity, forwards and backwards.")
    angular_max: float = number(1.2, 0.0, 10.0, "rad/s", "Maximum angular velocity, in both directions.")
    linear_acceleration: float = number(1.0, 0.0, 20.0, "m/s²", "Maximum linear acceleration.")
    angular_acceleration: float = number(4.0, 0.0, 50.0, "rad/s²", "Maximum angular acceleration.")
    linear_braking: float = number(
        0.0, 0.0, 20.0, "m/s²", "Maximum linear deceleration; 0: as much as linear_acceleration."
    )
    angular_braking: float = number(
        0.0, 0.0, 50.0, "rad/s²", "Maximum angular deceleration; 0: as much as angular_acceleration."
    )
    bumper: float = number(
        0.0, 0.0, 0.3, "m", "How much farther ahead the robot's body reaches than its software knows."
    )
    cmd_vel_timeout: float = number(
        0.5,
        0.0,
        60.0,
        "s",
        "Simulated time without a message on cmd_vel after which the robot stops; 0: never, it goes on.",
    )
    slip: float = number(0.01, 0.0, 0.9, "", "Wheel slip, as a fraction of the wheel's rotation.")
    turn_slip: float = number(
        0.0,
        0.0,
        0.9,
        "",
        "How much less the robot turns than its wheels do, as a fraction: they skid sideways in turns.",
    )
    slip_noise: float = number(0.003, 0.0, 0.1, "m", "Standard deviation of a wheel's travel over 1 m.")
    linear_dead_zone: float = number(
        0.0, 0.0, 1.0, "m/s", "A commanded linear velocity that is smaller does not move the robot."
    )
    angular_dead_zone: float = number(0.0, 0.0, 2.0, "rad/s", "The same for the angular velocity.")
    left_wheel_error: float = number(
        0.0,
        -0.5,
        0.5,
        "",
        "How much larger the left wheel's radius is than the robot knows, as a fraction of it: commands and odometry "
        "are both wrong by that.",
    )
    right_wheel_error: float = number(0.0, -0.5, 0.5, "", "The same for the right wheel.")
    omnidirectional: bool = switch(False, "Whether the base also drives sideways (linear.y of cmd_vel).")
    stall_time: float = 0.5

    @property
    def linear_deceleration(self) -> float:
        """Maximum linear deceleration, in m/s²."""
        return self.linear_braking or self.linear_acceleration

    @property
    def angular_deceleration(self) -> float:
        """Maximum angular deceleration, in rad/s²."""
        return self.angular_braking or self.angular_acceleration


class Robot:
    """A differential drive in the world.

    The way of a wheel on the ground is that of its turning, less the slip, with noise whose variance is proportional to
    the way (Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, 2004, section 5.2.4).

    Attributes:
        x: In world, in m.
        y: In world, in m.
        theta: In world, in rad.
        linear: Velocity by the wheels, in m/s forward.
        angular: Velocity by the wheels, in rad/s counter-clockwise.
        left: The way that the left wheel has turned in the last step, in m.
        right: The same for the right one.
        lateral: Velocity by the wheels, in m/s to the left; 0 unless the base is omnidirectional.
        side: The way to the left that the wheels have turned in the last step, in m.
        stalled: Whether something kept a wheel from turning in the last step.
    """

    __slots__ = (
        "_command",
        "_command_age",
        "_left_scale",
        "_linear_target",
        "_random",
        "_right_scale",
        "_settings",
        "_stalled_for",
        "angular",
        "lateral",
        "left",
        "linear",
        "right",
        "side",
        "stalled",
        "theta",
        "x",
        "y",
    )

    def __init__(self, settings: RobotSettings, pose: Pose, random: Random) -> None:
        """Set the robot down.

        Args:
            settings: Its properties.
            pose: In world.
            random: Where the noise comes from.
        """
        self._settings = settings
        self._random = random
        self._left_scale, self._right_scale = 1.0 + settings.left_wheel_error, 1.0 + settings.right_wheel_error
        self._command = STANDSTILL
        self._command_age = math.inf
        self.place(pose)

    @property
    def pose(self) -> Pose:
        """Of base_link in world."""
        return Pose(self.x, self.y, self.theta)

    @property
    def velocity(self) -> Velocity:
        """The velocity by the wheels."""
        return Velocity(self.linear, self.angular, self.lateral)

    @property
    def commanded(self) -> Velocity:
        """The velocity that a base which carries out its commands has."""
        return Velocity(*self._target())

    @property
    def radius(self) -> float:
        """Of the body, in m."""
        return self._settings.radius

    def place(self, pose: Pose) -> None:
        """Lift the robot and set it down somewhere else in the world, standing still."""
        self.x, self.y, self.theta = pose.x, pose.y, normalize_angle(pose.theta)
        self.linear = self.angular = self.left = self.right = self._linear_target = 0.0
        self.lateral = self.side = 0.0
        self.stalled = False
        self._stalled_for = 0.0

    @property
    def body(self) -> tuple[float, float]:
        """The centre of the body in world: base_link, unless the body reaches farther ahead than is known."""
        ahead = self._settings.bumper
        return self.x + ahead * math.cos(self.theta), self.y + ahead * math.sin(self.theta)

    def move_body(self, x: float, y: float) -> None:
        """Move the robot sideways, so that the centre of its body is at a place in world."""
        ahead = self._settings.bumper
        self.x, self.y = x - ahead * math.cos(self.theta), y - ahead * math.sin(self.theta)

    def command(self, velocity: Velocity) -> None:
        """Set the commanded velocity, as from cmd_vel: clamped to the limits, and ignored if it is not finite."""
        if not velocity.finite:
            return
        self._command = velocity
        self._command_age = 0.0
        if velocity == STANDSTILL:
            self._stalled_for = 0.0

    def step(
        self, dt: float, *, halted: bool = False, stuck: bool = False, worn: float = 0.0, goes_on: bool = False
    ) -> None:
        """Drive on for `dt` seconds, as if nothing stood in the way.

        Args:
            dt: In s, above 0.
            halted: The robot must not move, whatever the command.
            stuck: The left wheel does not turn.
            worn: How much smaller the right wheel is than it was, as a fraction of its radius.
            goes_on: The robot has no command timeout, whatever its settings say.
        """
        settings = self._settings
        self._command_age += dt
        halted = halted or self._is_left_alone(goes_on)
        linear, angular = (0.0, 0.0) if halted else self._target()
        if stuck:
            linear, angular = self._with_stuck_wheel(linear, angular, dt)
        else:
            self.stalled = False
            self._stalled_for = 0.0
        self._linear_target = linear
        self.linear = _approach(
            self.linear, linear, settings.linear_acceleration * dt, settings.linear_deceleration * dt
        )
        self.angular = _approach(
            self.angular, angular, settings.angular_acceleration * dt, settings.angular_deceleration * dt
        )
        if settings.omnidirectional:
            self._slide(dt, halted=halted or stuck)
        if self.linear == 0.0 == self.angular:
            self.left = self.right = 0.0
            return
        half = 0.5 * settings.wheel_separation * self.angular
        self.left = (self.linear - half) * dt
        self.right = (self.linear + half) * dt
        left = self._on_ground(self.left * self._left_scale)
        right = self._on_ground(self.right * self._right_scale * (1.0 - worn))
        turn = (right - left) / settings.wheel_separation * (1.0 - settings.turn_slip)
        way, heading = 0.5 * (left + right), self.theta + 0.5 * turn
        self.x += way * math.cos(heading)
        self.y += way * math.sin(heading)
        self.theta = normalize_angle(self.theta + turn)

    def _slide(self, dt: float, *, halted: bool) -> None:
        """Drive sideways."""
        settings = self._settings
        target = 0.0 if halted else min(settings.linear_max, max(-settings.linear_max, self._command.linear_y))
        self.lateral = _approach(
            self.lateral, target, settings.linear_acceleration * dt, settings.linear_deceleration * dt
        )
        self.side = self.lateral * dt
        way = self._on_ground(self.side)
        self.x -= way * math.sin(self.theta)
        self.y += way * math.cos(self.theta)

    def block(self, x: float, y: float, normal_x: float, normal_y: float) -> None:
        """Something solid stands in the way: the body slides along it, the wheels stall.

        Args:
            x: Where the centre of the body is kept, in world.
            y: The same.
            normal_x: The direction away from the obstacle, of length 1.
            normal_y: The same.
        """
        self.move_body(x, y)
        across = math.cos(self.theta) * normal_x + math.sin(self.theta) * normal_y
        if across * self.linear < 0.0:
            kept = 1.0 - across * across
            lost = 0.5 * (self.left + self.right) * (1.0 - kept)
            self.left -= lost
            self.right -= lost
            most = kept * abs(self._linear_target)
            self.linear = min(most, max(-most, self.linear))
            self.stalled = True
        beside = math.cos(self.theta) * normal_y - math.sin(self.theta) * normal_x
        if beside * self.lateral < 0.0:
            kept = 1.0 - beside * beside
            self.side, self.lateral = kept * self.side, kept * self.lateral

    def _is_left_alone(self, goes_on: bool) -> bool:
        """Whether the last command is older than the base's timeout, if it has one."""
        timeout = self._settings.cmd_vel_timeout
        return not goes_on and timeout > 0.0 and self._command_age > timeout + ROUNDING

    def _target(self) -> tuple[float, float]:
        settings, command = self._settings, self._command
        linear, angular = command.linear_x, command.angular_z
        if abs(linear) < settings.linear_dead_zone:
            linear = 0.0
        if abs(angular) < settings.angular_dead_zone:
            angular = 0.0
        return (
            min(settings.linear_max, max(-settings.linear_max, linear)),
            min(settings.angular_max, max(-settings.angular_max, angular)),
        )

    def _with_stuck_wheel(self, linear: float, angular: float, dt: float) -> tuple[float, float]:
        """The robot pivots around the wheel that is stuck, for as long as the motor bears it."""
        settings = self._settings
        half = 0.5 * settings.wheel_separation
        self.stalled = linear != angular * half
        if self.stalled:
            self._stalled_for += dt
        if self._stalled_for > settings.stall_time:
            self.stalled = False
            return 0.0, 0.0
        right = min(settings.linear_max, max(-settings.linear_max, linear + angular * half))
        turning = right / settings.wheel_separation
        turning = min(settings.angular_max, max(-settings.angular_max, turning))
        return turning * half, turning

    def _on_ground(self, way: float) -> float:
        settings = self._settings
        ground = way * (1.0 - settings.slip)
        if settings.slip_noise > 0.0 and way != 0.0:
            ground += self._random.gauss(0.0, settings.slip_noise * math.sqrt(abs(way)))
        return ground


def _approach(value: float, target: float, faster: float, slower: float) -> float:
    """The next value on the way to a target.

    Args:
        value: The last one.
        target: Where it goes.
        faster: The highest change away from 0.
        slower: The highest change towards 0.
    """
    if value * (target - value) >= 0.0:
        return value + min(faster, max(-faster, target - value))
    if abs(target - value) <= slower and value * target >= 0.0:
        return target
    if abs(value) > slower:
        return value - math.copysign(slower, value)
    # It gets to 0 within the step, and on to the other side for the rest of it.
    return math.copysign(min(abs(target), faster * (1.0 - abs(value) / slower)), -value)
