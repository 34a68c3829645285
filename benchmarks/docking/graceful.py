"""nav2's graceful control law, and docking with it as nav2 documents it for its docking server.

The law is written from its paper: J. J. Park and B. Kuipers, "A smooth control law for graceful motion of differential
wheeled mobile robots in 2D environment", ICRA 2011. Only the benchmark uses it: it compares laws, not nav2's server.
"""

import math
from dataclasses import dataclass

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import DockSettings

FREQUENCY = 50.0
"""Of nav2's control loop by default, in Hz."""
BEYOND = 0.25
"""How far beyond the dock the target of the approach is, in m."""
FILTER = 0.1
"""Weight of a detection in nav2's filter at each control step (filter_coef)."""
DETECTION_TIMEOUT = 1.0
"""Age of the last detection, in s, from which nav2 takes the dock for lost."""
DOCKED_WITHIN = 0.02
"""Distance from the docked pose, in m, within which the robot is taken to be docked (docking_threshold): that of the
simulated contacts. At nav2's default, 5 cm, the robot stops short of them."""
CHARGING_CURRENT = 0.5
"""Current into the battery, in A, above which nav2 takes it for charging."""
LINEAR_TOLERANCE, ANGULAR_TOLERANCE = 0.05, 0.05
"""How near to the staging pose a robot must be that backs off, in m and rad (undock_linear_tolerance and so on)."""
TURNED = Pose(theta=math.pi)


@dataclass(frozen=True, slots=True)
class GracefulLaw:
    """The law, with the names and the defaults of the parameters that nav2 documents; in m, rad and s."""

    k_phi: float = 3.0
    k_delta: float = 2.0
    beta: float = 0.4
    lambda_: float = 2.0
    v_linear_min: float = 0.1
    v_linear_max: float = 0.25
    v_angular_max: float = 0.75
    slowdown_radius: float = 0.25

    def curvature(self, robot: Pose, target: Pose) -> float:
        """Of the way to a target, in 1/m; 0 for a robot that is there."""
        way_x, way_y = target.x - robot.x, target.y - robot.y
        r, sight = math.hypot(way_x, way_y), math.atan2(way_y, way_x)
        if r < 1e-6:
            return 0.0
        theta, delta = normalize_angle(target.theta - sight), normalize_angle(robot.theta - sight)
        slow = math.atan(-self.k_phi * theta)
        fast = 1.0 + self.k_phi / (1.0 + (self.k_phi * theta) ** 2)
        return -(self.k_delta * (delta - slow) + fast * math.sin(delta)) / r

    def velocity(self, robot: Pose, target: Pose, *, backward: bool = False) -> Velocity:
        """The next velocity on the way to a target: a robot that reverses is one that is turned round."""
        if backward:
            reverse = self.velocity(robot.compose(TURNED), target.compose(TURNED))
            return Velocity(-reverse.linear_x, reverse.angular_z)
        curvature = self.curvature(robot, target)
        near = robot.distance_to(target) / self.slowdown_radius
        speed = self.v_linear_max * min(near, 1.0 / (1.0 + self.beta * abs(curvature) ** self.lambda_))
        speed = max(self.v_linear_min, speed)
        if abs(curvature) * speed > self.v_angular_max:
            speed = self.v_angular_max / abs(curvature)
        return Velocity(speed, curvature * speed)


class GracefulGoal:
    """A docking goal that our own one takes to the staging pose, and nav2's law from there onto the dock.

    As nav2's server does, by its documentation: the approach ends where the robot is within 2 cm of the docked
    pose or charges; then it stands and waits for the charge. What fails is retried after backing off to the staging
    pose by the same law.
    """

    def __init__(self, goal: Goal, law: GracefulLaw, settings: DockSettings) -> None:
        """Begin with our own goal.

        Args:
            goal: It finds the dock and drives to the staging pose.
            law: What drives then.
            settings: Time limits, the number of retries, and where the docked pose is.
        """
        self._goal = goal
        self._law = law
        self._settings = settings
        self._staging: Pose | None = None
        self._marker: Pose | None = None
        self._seen_at = -math.inf
        self._retries = 0

    def step(self, observation: Observation) -> Command | Outcome:
        """Return the next command, or the outcome."""
        if self._staging is None:
            step = self._goal.step(observation)
            if isinstance(step, Outcome) or step.stage is not Stage.CONTROLLING:
                return step
            self._staging, self._retries = step.staging_pose, step.retries
            self._enter(Stage.CONTROLLING, observation.now)
        battery, odometry = observation.battery, observation.odometry
        assert self._staging is not None
        assert odometry is not None
        charges = battery is not None and battery.current > CHARGING_CURRENT
        if self._stage is Stage.CONTROLLING:
            return self._approach(odometry.pose, observation, charges=charges)
        if self._stage is Stage.WAIT_FOR_CHARGE:
            return self._wait(observation.now, charges=charges)
        return self._back_off(odometry.pose, self._staging, observation.now)

    def _approach(self, robot: Pose, observation: Observation, *, charges: bool) -> Command | Outcome:
        docked = None if self._marker is None else self._settings.dock.docked(self._marker)
        if charges or (docked is not None and robot.distance_to(docked) < DOCKED_WITHIN):
            return self._enter(Stage.WAIT_FOR_CHARGE, observation.now)
        if not self._sees(observation):
            return self._retry(ErrorCode.FAILED_TO_DETECT_DOCK, observation.now)
        if self._is_over(self._settings.timeouts.dock_approach_timeout, observation.now):
            return self._retry(ErrorCode.FAILED_TO_CONTROL, observation.now)
        assert self._marker is not None
        target = self._settings.dock.docked(self._marker).compose(Pose(BEYOND))
        return Command(self._stage, self._law.velocity(robot, target), retries=self._retries)

    def _wait(self, now: float, *, charges: bool) -> Command | Outcome:
        if charges:
            return Outcome(End.SUCCEEDED, retries=self._retries)
        if self._is_over(self._settings.timeouts.wait_charge_timeout, now):
            return self._retry(ErrorCode.FAILED_TO_CHARGE, now)
        return Command(self._stage, STANDSTILL, retries=self._retries)

    def _back_off(self, robot: Pose, staging: Pose, now: float) -> Command | Outcome:
        off = robot.relative_to(staging)
        if math.hypot(off.x, off.y) < LINEAR_TOLERANCE and abs(off.theta) < ANGULAR_TOLERANCE:
            return self._enter(Stage.CONTROLLING, now)
        if self._is_over(self._settings.timeouts.dock_approach_timeout, now):
            return Outcome(End.ABORTED, ErrorCode.FAILED_TO_CONTROL, retries=self._retries)
        return Command(self._stage, self._law.velocity(robot, staging, backward=True), retries=self._retries)

    def _sees(self, observation: Observation) -> bool:
        """Filter the last detection, at each step again as nav2 does; False where the dock is lost."""
        seen = observation.marker
        if seen is None or observation.now - seen.stamp > DETECTION_TIMEOUT:
            return False
        if self._marker is None or seen.stamp - self._seen_at > DETECTION_TIMEOUT:
            self._marker = seen.pose
        else:
            old, new = self._marker, seen.pose
            turn = normalize_angle(new.theta - old.theta)
            self._marker = Pose(
                old.x + FILTER * (new.x - old.x),
                old.y + FILTER * (new.y - old.y),
                normalize_angle(old.theta + FILTER * turn),
            )
        self._seen_at = seen.stamp
        return True

    def _is_over(self, limit: float, now: float) -> bool:
        return now - self._entered_at > limit

    def _enter(self, stage: Stage, now: float) -> Command:
        self._stage, self._entered_at = stage, now
        return Command(stage, STANDSTILL, retries=self._retries)

    def _retry(self, code: ErrorCode, now: float) -> Command | Outcome:
        if self._retries >= self._settings.timeouts.max_retries:
            return Outcome(End.ABORTED, code, retries=self._retries)
        self._retries += 1
        return self._enter(Stage.RETRY, now)
