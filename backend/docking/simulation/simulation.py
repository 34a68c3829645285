"""The simulation: the robot, its battery, its sensors and the dock, step by step.

simulation = Simulation(Settings(start=Pose(-1.5, 0.4, -0.3)), seed=7)
while not simulation.charging:
    command = controller.step(simulation.observe(), 0.1)   # a velocity
    simulation.run(0.1, command)
"""

import math
from dataclasses import dataclass, field, replace
from random import Random

from docking.core.battery import BatteryReading, PowerSupplyStatus
from docking.core.geometry import Pose
from docking.core.observation import InfraredReading, MarkerDetection, Observation, Odometry, Velocity
from docking.simulation.battery import BatteryMeasurement, BatteryPack, BatterySettings
from docking.simulation.dock import Dock, DockSettings
from docking.simulation.faults import Fault
from docking.simulation.infrared import InfraredReceivers, InfraredSettings
from docking.simulation.marker import MarkerCamera, MarkerSettings
from docking.simulation.odometry import DriftingOdometry, OdometrySettings
from docking.simulation.robot import Robot, RobotSettings

INSTANT = 1e-6
"""So short a time, in s, that nothing happens in it."""
STEP = 0.02
"""The longest step, in s, that the model is meant for."""
START = Pose(-1.5, 0.4, -0.3)
"""Where the robot stands at first, in world, unless it is said."""
BATTERY_RATE = 10.0
"""Measurements of the battery a second."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that can be chosen.

    Attributes:
        start: Where the robot stands at first, in world.
        electronics_power: What the robot needs while it stands still, in W.
        driving_power: What its motors need beyond that at 1 m/s, in W.
        stall_power: What they need beyond that while a wheel is kept from turning, in W.
        robot: The robot.
        odometry: Its reckoning.
        marker: Its camera and the dock's marker.
        infrared: Its receivers and the dock's beacon.
        battery: Its battery and the dock's charger.
        dock: The dock.
    """

    start: Pose = START
    electronics_power: float = 2.5
    driving_power: float = 20.0
    stall_power: float = 6.0
    robot: RobotSettings = field(default_factory=RobotSettings)
    odometry: OdometrySettings = field(default_factory=OdometrySettings)
    marker: MarkerSettings = field(default_factory=MarkerSettings)
    infrared: InfraredSettings = field(default_factory=InfraredSettings)
    battery: BatterySettings = field(default_factory=BatterySettings)
    dock: DockSettings = field(default_factory=DockSettings)


@dataclass(frozen=True, slots=True)
class Sighting:
    """The marker as the camera saw it.

    Attributes:
        marker: In base_link at that moment.
        odometry: base_link in odom at that moment.
        stamp: Simulated seconds.
    """

    marker: Pose
    odometry: Pose
    stamp: float


@dataclass(frozen=True, slots=True)
class Ranges:
    """What the infrared receivers measured, in m; infinite where the beacon is not seen.

    Attributes:
        left: In m.
        center: In m.
        right: In m.
        stamp: Simulated seconds.
    """

    left: float
    center: float
    right: float
    stamp: float


class Simulation:
    """One robot and its dock. The same seed and the same calls give the same again.

    Attributes:
        time: Simulated seconds since the start.
        robot: The robot as it is in truth.
        odometry: The robot's own reckoning.
        battery: Its battery.
        dock: The dock.
        faults: What is broken now; switch with `set_fault`.
        halted: Whether the robot must not move, whatever it is told.
        contact: Whether the robot touches the dock's contacts.
        bumps: How often the robot has run into the dock without touching its contacts.
        sighting: The last time the camera saw the marker.
        ranges: The last infrared measurement.
        measurement: The last of the battery, with the moment.
    """

    def __init__(self, settings: Settings | None = None, seed: int = 0) -> None:
        """Build it all and set the robot down.

        Args:
            settings: None for the defaults.
            seed: Decides on all that is random; every part has numbers of its own, so that a fault in one does not
                change the noise of another.
        """
        self.settings = settings or Settings()
        self._seed = seed
        self.faults: frozenset[Fault] = frozenset()
        self.halted = False
        self.reset()

    def reset(self) -> None:
        """Begin again: everything as at the start, the same noise, no faults. `halted` stays as it is."""
        settings = self.settings
        self.time = 0.0
        self.faults = frozenset()
        self.robot = Robot(settings.robot, settings.start, self._random("robot"))
        self.dock = Dock(settings.dock)
        self.odometry = DriftingOdometry(settings.odometry, settings.robot.wheel_separation, self._random("odometry"))
        self.battery = BatteryPack(settings.battery, self._random("battery"))
        self._camera = MarkerCamera(settings.marker, self._random("marker"))
        self._receivers = InfraredReceivers(settings.infrared, self._random("infrared"))
        self._picture_due = self._ranges_due = self._measurement_due = 0.0
        self.sighting: Sighting | None = None
        self.ranges: Ranges | None = None
        self.measurement: tuple[BatteryMeasurement, float] | None = None
        self.contact = False
        self.bumps = 0
        self._touching = self._keep_out()
        self._feed(INSTANT)
        self._sense()

    # What is done to it.

    def step(self, dt: float = STEP, command: Velocity | None = None) -> None:
        """Let time pass.

        Args:
            dt: In s, above 0 and at most `STEP`.
            command: A velocity that arrives now, as from cmd_vel; None where none does.
        """
        if command is not None:
            self.robot.command(command)
        self.time += dt
        robot = self.robot
        robot.step(dt, halted=self.halted or self.battery.empty, stuck=Fault.STUCK_WHEEL in self.faults)
        touching = self._keep_out()
        if touching and not self._touching and not self.contact:
            self.bumps += 1
        self._touching = touching
        self.odometry.step(robot.left, robot.right)
        self._feed(dt)
        self._sense()

    def run(self, seconds: float, command: Velocity | None = None) -> None:
        """Let time pass in equal steps of at most `STEP`.

        Args:
            seconds: How long.
            command: A velocity that arrives at the beginning.
        """
        count = math.ceil(seconds / STEP - 1e-9)
        for number in range(count):
            self.step(seconds / count, command if number == 0 else None)

    def place(self, pose: Pose) -> None:
        """Lift the robot and set it down elsewhere, standing still. Odometry does not notice.

        Nothing can be put into the dock: it will stand beside it.

        Args:
            pose: base_link in world.
        """
        self.robot.place(pose)
        self._touching = self._keep_out()

    def push(self, by: Pose) -> None:
        """Push the robot over the ground with its wheels blocked; odometry does not notice.

        Args:
            by: Where it then is, in the frame of base_link before.
        """
        self.place(self.robot.pose.compose(by))

    def set_fault(self, fault: Fault, active: bool) -> None:
        """Switch a fault on or off."""
        self.faults = self.faults | {fault} if active else self.faults - {fault}

    # What is known of it.

    @property
    def charging(self) -> bool:
        """Whether the charger gives power, or has given all that the battery takes."""
        return self.battery.status in {PowerSupplyStatus.CHARGING, PowerSupplyStatus.FULL}

    @property
    def odometry_velocity(self) -> Velocity:
        """As the wheels seem to turn, in base_link."""
        robot = self.robot
        half = 0.5 * self.settings.robot.wheel_separation * robot.angular
        return Velocity(*self.odometry.measure(robot.linear - half, robot.linear + half))

    def observe(self, now: float | None = None) -> Observation:
        """What a docking node knows after it has heard all topics.

        Args:
            now: The moment by the caller's clock, which its stamps will be of; None is simulated time.
        """
        now = self.time if now is None else now
        offset = now - self.time
        sighting, ranges, measured = self.sighting, self.ranges, self.measurement
        return Observation(
            now=now,
            battery=None if measured is None else BatteryReading(measured[0].status, measured[1] + offset, measured[0]),
            odometry=Odometry(self.odometry.pose, self.odometry_velocity, now),
            marker=None
            if sighting is None
            else MarkerDetection(sighting.odometry.compose(sighting.marker), sighting.stamp + offset),
            infrared=None
            if ranges is None
            else InfraredReading(ranges.left, ranges.center, ranges.right, ranges.stamp + offset),
        )

    # How it goes on.

    def _keep_out(self) -> bool:
        """The dock is solid: whether the robot would have been in it."""
        robot = self.robot
        obstruction = self.dock.obstruct(robot.x, robot.y, robot.radius)
        if obstruction is not None:
            robot.block(obstruction.x, obstruction.y, obstruction.normal_x, obstruction.normal_y)
        self.contact = self.dock.in_contact(robot.x, robot.y, robot.theta)
        return obstruction is not None

    def _random(self, part: str) -> Random:
        return Random(f"{self._seed} {part}")  # noqa: S311 - noise, not secrets

    def _feed(self, dt: float) -> None:
        """The charger, or the battery, gives what the robot needs."""
        powered = Fault.DEAD_CHARGER not in self.faults
        self.battery.step(dt, self._power(dt), connected=self.contact, powered=powered)

    def _power(self, dt: float) -> float:
        settings, robot = self.settings, self.robot
        speed = 0.5 * (abs(robot.left) + abs(robot.right)) / dt
        stalled = settings.stall_power if robot.stalled else 0.0
        return settings.electronics_power + settings.driving_power * speed + stalled

    def _sense(self) -> None:
        """Each sensor measures when its time has come."""
        now = self.time + 1e-9
        if now >= self._picture_due:
            self._picture_due += 1.0 / self.settings.marker.rate
            self._look()
        if now >= self._ranges_due:
            self._ranges_due += 1.0 / self.settings.infrared.rate
            self.ranges = Ranges(*self._receivers.measure(self.robot.pose), self.time)
        if now >= self._measurement_due:
            self._measurement_due += 1.0 / BATTERY_RATE
            self._measure_battery()

    def _look(self) -> None:
        marker = self._camera.look(self.robot.pose)
        if marker is not None and Fault.OCCLUDED_MARKER not in self.faults:
            self.sighting = Sighting(marker, self.odometry.pose, self.time)

    def _measure_battery(self) -> None:
        if Fault.SILENT_BATTERY in self.faults:
            return
        measured = self.battery.measure()
        if Fault.PERCENTAGE_0_TO_100 in self.faults:
            measured = replace(measured, percentage=100.0 * measured.percentage)
        self.measurement = (measured, self.time)
