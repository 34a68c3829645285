"""The simulation: the robot, its battery, its sensors and the dock, step by step.

simulation = Simulation(Settings(start=Pose(-1.5, 0.4, -0.3)), seed=7)
while not simulation.charging:
    command = controller.step(simulation.observe(), 0.1)   # a velocity
    simulation.run(0.1, command)
"""

import math
from dataclasses import replace
from random import Random

from docking.core.battery import BatteryReading, PowerSupplyStatus
from docking.core.geometry import Pose
from docking.core.observation import (
    STANDSTILL,
    InfraredReading,
    MarkerDetection,
    Observation,
    Odometry,
    Scan,
    Velocity,
)
from docking.estimation.scan import place, points_of
from docking.estimation.track import Track
from docking.simulation.battery import BatteryMeasurement, BatteryPack
from docking.simulation.delay import Delay
from docking.simulation.dock import Dock
from docking.simulation.faults import Fault
from docking.simulation.infrared import InfraredReceivers
from docking.simulation.laser import ANGLE_MIN, LaserScanner
from docking.simulation.marker import MarkerCamera
from docking.simulation.obstacle import Obstacle
from docking.simulation.odometry import DriftingOdometry
from docking.simulation.readings import LaserScan, Ranges, Sighting
from docking.simulation.robot import Robot
from docking.simulation.settings import Settings

INSTANT = 1e-6
"""So short a time, in s, that nothing happens in it."""
STEP = 0.02
"""The longest step, in s, that the model is meant for."""
BATTERY_RATE = 10.0
"""Measurements of the battery a second."""
LATE = 0.3
"""How much later commands arrive with the fault `late_commands`, in s."""
WORN = 0.1
"""How much smaller the right wheel is with the fault `worn_wheel`, as a fraction of its radius."""
WRONG = 1.0 / 3.0
"""The part of the detections that are wrong with the fault `wrong_detections`."""
GHOSTS = 0.1
"""The part of the infrared distances that are anything with the fault `infrared_ghosts`."""
IN_THE_WAY = Obstacle(-0.55, 0.05, 0.08)
"""What stands in front of the dock with the fault `obstacle`."""


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
        bumps: How often the robot has run into something, but for the dock while it touches the contacts.
        track: Odometry as it arrived, by its stamps.
        reckoned_at: The stamp of the last odometry that arrived, in simulated seconds.
        sighting: The last detection of the marker that arrived.
        ranges: The last infrared measurement.
        scanning: Whether the laser scanner runs; it costs time.
        scan: The last one.
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
        self.scanning = False
        self.reset()

    def reset(self) -> None:
        """Begin again: as at the start, with the same noise and no faults. `halted` and `scanning` stay."""
        settings = self.settings
        self.time = 0.0
        self.faults = frozenset()
        self.robot = Robot(settings.robot, settings.start, self._random("robot"))
        self.dock = Dock(settings.dock)
        self.odometry = DriftingOdometry(settings.odometry, settings.robot.wheel_separation, self._random("odometry"))
        self.battery = BatteryPack(settings.battery, self._random("battery"))
        self._camera = MarkerCamera(settings.marker, self._random("marker"), self._random("outliers"))
        self._receivers = InfraredReceivers(settings.infrared, self._random("infrared"), self._random("ghosts"))
        self._scanner = LaserScanner(settings.laser, self._random("laser").getrandbits(32))
        self._picture_due = self._scan_due = self._ranges_due = self._measurement_due = 0.0
        self._bouncing = self._random("bounce")
        self._touched_at: float | None = None
        self._commands: Delay[Velocity] = Delay()
        self._readings: Delay[tuple[float, Odometry]] = Delay()
        self._detections: Delay[tuple[float, Pose]] = Delay()
        self.track = Track()
        self.reckoned_at = 0.0
        self.sighting: Sighting | None = None
        self.ranges: Ranges | None = None
        self.scan: LaserScan | None = None
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
        robot = self.robot
        if command is not None:
            late = LATE if Fault.LATE_COMMANDS in self.faults else 0.0
            self._commands.send(command, self.time + self.settings.command_delay + late)
        for arrived in self._commands.arrived(self.time):
            robot.command(arrived)
        self.time += dt
        robot.step(
            dt,
            halted=self.halted or self.battery.empty,
            stuck=Fault.STUCK_WHEEL in self.faults,
            worn=WORN if Fault.WORN_WHEEL in self.faults else 0.0,
        )
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
        for step in range(count):
            self.step(seconds / count, command if step == 0 else None)

    def place(self, pose: Pose) -> None:
        """Lift the robot and set it down elsewhere, standing still. Odometry does not notice.

        A robot that is placed inside the dock ends up beside it.

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
    def obstacles(self) -> tuple[Obstacle, ...]:
        """What stands around now."""
        more = (IN_THE_WAY,) if Fault.OBSTACLE in self.faults else ()
        return self.settings.obstacles + more

    @property
    def odometry_velocity(self) -> Velocity:
        """As the wheels seem to turn, in base_link; 0 if odometry has no velocity."""
        if not self.settings.odometry.twist:
            return STANDSTILL
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
        odometry = self.track.latest
        return Observation(
            now=now,
            battery=None if measured is None else _reading(measured[0], measured[1] + offset),
            odometry=None if odometry is None else replace(odometry, stamp=odometry.stamp + offset),
            marker=None
            if sighting is None
            else MarkerDetection(sighting.odometry.compose(sighting.marker), sighting.at + offset),
            scan=self._observe_scan(offset),
            infrared=None
            if ranges is None
            else InfraredReading(ranges.left, ranges.center, ranges.right, ranges.at + offset),
        )

    def _observe_scan(self, offset: float) -> Scan | None:
        if self.scan is None:
            return None
        laser = self.settings.laser
        points = points_of(
            self.scan.distances,
            angle_min=ANGLE_MIN,
            angle_increment=laser.angle_increment,
            range_min=laser.minimum,
            range_max=laser.range,
        )
        return Scan(place(points, self.scan.odometry.compose(laser.mount)), self.scan.stamp + offset)

    # How it goes on.

    def _keep_out(self) -> bool:
        """The dock and obstacles are solid: whether the robot would have been in one."""
        robot, blocked = self.robot, False
        solids: tuple[Dock | Obstacle, ...] = (self.dock, *self.obstacles)
        for solid in solids:
            obstruction = solid.obstruct(robot.x, robot.y, robot.radius)
            if obstruction is not None:
                robot.block(obstruction.x, obstruction.y, obstruction.normal_x, obstruction.normal_y)
                blocked = True
        self.contact = self.dock.in_contact(robot.x, robot.y, robot.theta)
        if not self.contact:
            self._touched_at = None
        elif self._touched_at is None:
            self._touched_at = self.time
        return blocked

    def _random(self, part: str) -> Random:
        return Random(f"{self._seed} {part}")  # noqa: S311 - noise, not secrets

    def _feed(self, dt: float) -> None:
        """The charger, or the battery, gives what the robot needs."""
        powered = Fault.DEAD_CHARGER not in self.faults
        self.battery.step(dt, self._power(dt), connected=self._connected(), powered=powered)

    def _connected(self) -> bool:
        """Whether current can flow: the contacts bounce at first."""
        touched_at = self._touched_at
        if touched_at is None:
            return False
        return self.time - touched_at >= self.settings.dock.bounce or self._bouncing.random() < 0.5

    def _power(self, dt: float) -> float:
        settings, robot = self.settings, self.robot
        speed = 0.5 * (abs(robot.left) + abs(robot.right)) / dt
        stalled = settings.stall_power if robot.stalled else 0.0
        return settings.electronics_power + settings.driving_power * speed + stalled

    def _sense(self) -> None:
        """Each sensor measures when its time has come; what was measured arrives when its time has come."""
        now = self.time + 1e-9
        self._reckon()
        if now >= self._picture_due:
            self._picture_due += 1.0 / self.settings.marker.rate
            self._look()
        self._detect()
        if now >= self._ranges_due:
            self._ranges_due += 1.0 / self.settings.infrared.rate
            self._measure_ranges()
        if self.scanning and now >= self._scan_due:
            self._scan_due = self.time + 1.0 / self.settings.laser.rate
            distances = self._scanner.scan(self.robot.pose, self.dock, self.obstacles)
            self.scan = LaserScan(distances, self.odometry.pose, self.time)
        if now >= self._measurement_due:
            self._measurement_due += 1.0 / BATTERY_RATE
            self._measure_battery()

    def _reckon(self) -> None:
        """Odometry of now is sent, that of earlier arrives."""
        settings, now = self.settings.odometry, self.time
        arrives_at = now + settings.delay
        stamp = now if settings.honest_stamps else arrives_at
        self._readings.send((stamp, Odometry(self.odometry.pose, self.odometry_velocity, arrives_at)), arrives_at)
        for measured_at, reading in self._readings.arrived(now):
            self.track.add(measured_at, reading)
            self.reckoned_at = measured_at

    def _look(self) -> None:
        outliers = WRONG if Fault.WRONG_DETECTIONS in self.faults else 0.0
        marker = self._camera.look(self.robot.pose, self.time, self.obstacles, outliers)
        if marker is not None and Fault.OCCLUDED_MARKER not in self.faults:
            settings = self.settings.marker
            arrives_at = self.time + settings.delay
            self._detections.send((self.time if settings.honest_stamps else arrives_at, marker), arrives_at)

    def _detect(self) -> None:
        """Detections arrive, and are put where odometry says that the robot was."""
        for stamp, marker in self._detections.arrived(self.time):
            try:
                odometry = self.track.at(stamp)
            except LookupError:
                continue
            self.sighting = Sighting(marker, odometry.pose, stamp, min(odometry.stamp, self.time))

    def _measure_ranges(self) -> None:
        ranges = self._receivers.measure(
            self.robot.pose,
            self.time,
            hidden=Fault.HIDDEN_BEACON in self.faults,
            ghosts=GHOSTS if Fault.INFRARED_GHOSTS in self.faults else 0.0,
        )
        self.ranges = Ranges(*ranges, self.time, self.track.arrival(self.time, self.time))

    def _measure_battery(self) -> None:
        if Fault.SILENT_BATTERY in self.faults:
            return
        measured = self.battery.measure()
        if Fault.PERCENTAGE_0_TO_100 in self.faults:
            measured = replace(measured, percentage=100.0 * measured.percentage)
        self.measurement = (measured, self.time)


def _reading(measured: BatteryMeasurement, at: float) -> BatteryReading:
    return BatteryReading(measured.status, at, measured, measured.percentage, measured.current)
