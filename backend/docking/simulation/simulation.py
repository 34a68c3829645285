"""The simulation: the robot, its battery, its sensors and the dock, step by step.

simulation = Simulation(Settings(start=Pose(-1.5, 0.4, -0.3)), seed=7)
while not simulation.charging:
    command = controller.step(simulation.observe(), 0.1)   # a velocity
    simulation.run(0.1, command)
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random

from docking.core.battery import BatteryReading, PowerSupplyStatus
from docking.core.geometry import Pose
from docking.core.observation import (
    STANDSTILL,
    InfraredReading,
    Joint,
    MarkerDetection,
    Observation,
    Odometry,
    Scan,
    Velocity,
)
from docking.core.transform import place
from docking.estimation.track import Track
from docking.simulation.battery import BatteryMeasurement, BatteryPack
from docking.simulation.box import Box
from docking.simulation.collisions import Collisions, Touch
from docking.simulation.delay import Delay
from docking.simulation.dock import DOCKED, Dock
from docking.simulation.faults import (
    AHEAD,
    GHOSTS,
    IN_THE_WAY,
    JUMP,
    LAGGING,
    LATE,
    LOST,
    ON_THE_DOCK,
    REPEATING,
    WORN,
    WRONG,
    Fault,
)
from docking.simulation.infrared import InfraredReceivers
from docking.simulation.laser import ANGLE_MIN, Distances, LaserScanner
from docking.simulation.localization import Localization
from docking.simulation.marker import MarkerCamera, camera_mount
from docking.simulation.obstacle import Obstacle
from docking.simulation.odometry import DriftingOdometry, Repeater
from docking.simulation.others import not_pushing
from docking.simulation.readings import LaserScan, Sighting
from docking.simulation.repeating import DetectorFaults, Freezer
from docking.simulation.robot import Robot
from docking.simulation.settings import Settings
from robot_io.laser import points_of

INSTANT = 1e-6
"""A negligible time, in s."""
STEP = 0.02
"""The longest step, in s, that the model is meant for."""
LEFT_WHEEL, RIGHT_WHEEL = "left_wheel_joint", "right_wheel_joint"
WHEEL_RADIUS = 0.033
"""In m."""
ROLLING, PRESSING = 0.2, 2.5
"""Effort of a wheel's joint, in N·m, while the robot drives, and while something keeps it from that."""


class Simulation:
    """One robot and its dock. The same seed and the same calls give the same again.

    Attributes:
        time: Simulated seconds since the start.
        robot: The robot as it is in truth.
        odometry: The robot's own reckoning.
        battery: Its battery.
        dock: The dock.
        faults: The active faults; switch with `set_fault`.
        halted: Whether the robot stands still and ignores commands.
        others: The bodies of other robots; change with `meet`.
        track: Odometry as it arrived, by its stamps.
        reading: The last odometry that arrived, after its stamp in simulated seconds.
        detections: The last of a marker that arrived: stamp, and marker in base_link; two if there is a second marker.
        sightings: The last ones that odometry has a pose for.
        ranges: The last infrared measurement, after its moment in simulated seconds.
        scanning: Whether the laser scanner runs; it costs time.
        scan: The last one.
        measurement: The last of the battery, with the moment.
    """

    def __init__(self, settings: Settings | None = None, seed: int = 0, others: tuple[Obstacle, ...] = ()) -> None:
        """Build it all and set the robot down.

        Args:
            settings: None for the defaults.
            seed: Decides on all that is random; every part has numbers of its own, so that a fault in one does not
                change the noise of another.
            others: The bodies of other robots.
        """
        self.settings = settings or Settings()
        self._seed = seed
        self.faults: frozenset[Fault] = frozenset()
        self.halted = False
        self.scanning = False
        self.others = others
        self.reset()

    def reset(self) -> None:
        """Begin again: as at the start, with the same noise and no faults. `halted`, `scanning` and `others` stay."""
        settings = self.settings
        self.time = 0.0
        self.faults = frozenset()
        self.robot = Robot(settings.robot, settings.start, self._random("robot"))
        self.dock = Dock(settings.dock, settings.docks)
        self.odometry = DriftingOdometry(settings.odometry, settings.robot.wheel_separation, self._random("odometry"))
        self.battery = BatteryPack(settings.battery, self._random("battery"))
        numbers = ("", *(f" {number}" for number in range(2, len(self.dock.places) + 1)))
        self._cameras = [
            MarkerCamera(settings.marker, self._random(f"marker{number}"), self._random(f"outliers{number}"))
            for number in numbers
        ]
        self._second = MarkerCamera(settings.marker, self._random("second"), self._random("second outliers"))
        self._localization = Localization(settings.localization, self._random("localization"))
        self._receivers = InfraredReceivers(settings.infrared, self._random("infrared"), self._random("ghosts"))
        self._scanner = LaserScanner(settings.laser, self._random("laser").getrandbits(32))
        self._picture_due = self._scan_due = self._ranges_due = self._measurement_due = 0.0
        self._collisions = Collisions(self.dock, self._random("bounce"), settings.room)
        self._commands: Delay[Velocity] = Delay()
        self._network = self._random("network")
        self._readings: Delay[tuple[float, Odometry]] = Delay()
        self._detections: Delay[tuple[float, list[Pose]]] = Delay()
        self.track = Track()
        self.reading: tuple[float, Odometry] | None = None
        self._repeater = Repeater()
        self._detector_faults = DetectorFaults()
        self._frozen_ranges: Freezer[InfraredReading] = Freezer()
        self._frozen_scan: Freezer[Distances] = Freezer()
        self.detections: tuple[tuple[float, Pose], ...] = ()
        self.sightings: tuple[Sighting, ...] = ()
        self.ranges: tuple[float, InfraredReading] | None = None
        self.scan: LaserScan | None = None
        self.measurement: tuple[BatteryMeasurement, float] | None = None
        self._collide(driven=False)
        self._feed(INSTANT)
        self._sense()

    # Inputs.

    def step(self, dt: float = STEP, command: Velocity | None = None) -> None:
        """Let time pass.

        Args:
            dt: In s, above 0 and at most `STEP`.
            command: A velocity that arrives now, as from cmd_vel; None where none does.
        """
        robot = self.robot
        if command is not None:
            self.command(command)
        for arrived in self._commands.arrived(self.time):
            robot.command(arrived)
        self.time += dt
        robot.step(
            dt,
            halted=self.halted or self.battery.empty,
            stuck=Fault.STUCK_WHEEL in self.faults,
            worn=WORN if Fault.WORN_WHEEL in self.faults else 0.0,
            goes_on=Fault.NO_COMMAND_TIMEOUT in self.faults,
        )
        self._collide()
        self.odometry.step(*self._wheel_ways(dt))
        self._feed(dt)
        self._sense()

    def command(self, velocity: Velocity) -> None:
        """Send a velocity, as on cmd_vel: it arrives late, or never, if that is chosen."""
        loss = max(self.settings.command_loss, LOST if Fault.LOST_COMMANDS in self.faults else 0.0)
        if loss == 0.0 or self._network.random() >= loss:
            late = LATE if Fault.LATE_COMMANDS in self.faults else 0.0
            self._commands.send(velocity, self.time + self.settings.command_delay + late)

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

        A robot that is placed inside the dock ends up next to it.

        Args:
            pose: base_link in world.
        """
        self.robot.place(pose)
        self._collide(driven=False)

    def push(self, by: Pose) -> None:
        """Push the robot over the ground with its wheels blocked; odometry does not notice.

        Args:
            by: Where it then is, in the frame of base_link before.
        """
        self.place(self.robot.pose.compose(by))

    def meet(self, others: Sequence[Obstacle]) -> None:
        """Put other robots where they are now. They block the robot, but never push it.

        Args:
            others: Their bodies.
        """
        self.others = not_pushing(others, *self.robot.body, self.robot.radius)

    def set_fault(self, fault: Fault, active: bool) -> None:
        """Switch a fault on or off."""
        self.faults = self.faults | {fault} if active else self.faults - {fault}

    # Outputs.

    @property
    def charging(self) -> bool:
        """Whether the charger gives power, or has given all that the battery takes."""
        return self.battery.status in {PowerSupplyStatus.CHARGING, PowerSupplyStatus.FULL}

    @property
    def contact(self) -> bool:
        """Whether the robot touches the dock's contacts."""
        return self._collisions.contact

    @property
    def presses(self) -> int:
        """The number of times that the robot came onto the contacts."""
        return self._collisions.presses

    @property
    def bumps(self) -> int:
        """The number of times that the robot ran into something, but for the dock while it touches the contacts."""
        return self._collisions.bumps

    @property
    def touches(self) -> Sequence[Touch]:
        """The contacts with the dock that the robot drove into."""
        return self._collisions.touches

    @property
    def detection(self) -> tuple[float, Pose] | None:
        """The last of `detections`."""
        return self.detections[-1] if self.detections else None

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The current obstacles, and other robots."""
        return self.fixed_obstacles + self.others

    @property
    def fixed_obstacles(self) -> tuple[Obstacle, ...]:
        """The current obstacles that are no robots of their own."""
        more = {Fault.OBSTACLE: IN_THE_WAY, Fault.OCCUPIED_DOCK: ON_THE_DOCK}
        return self.settings.obstacles + tuple(one for fault, one in more.items() if fault in self.faults)

    @property
    def odometry_origin(self) -> Pose:
        """Odom in world: the start pose, but for what odometry has drifted."""
        return self.robot.pose.compose(self.odometry.pose.inverse())

    @property
    def located_docked(self) -> Pose:
        """base_link of the docked robot in odom, by the localization."""
        return self.odometry_origin.inverse().compose(DOCKED).compose(self._localization.off)

    @property
    def located_origin(self) -> Pose:
        """Odom in world, by the localization."""
        return DOCKED.compose(self.located_docked.inverse())

    @property
    def wheels(self) -> dict[str, tuple[float, float]]:
        """The velocity of each wheel's joint, in rad/s, and its effort, in N·m."""
        robot = self.robot
        half = 0.5 * self.settings.robot.wheel_separation * robot.angular
        speeds = {LEFT_WHEEL: robot.linear - half, RIGHT_WHEEL: robot.linear + half}
        effort = PRESSING if robot.stalled else ROLLING
        return {
            name: (speed / WHEEL_RADIUS, effort if robot.stalled or speed else 0.0) for name, speed in speeds.items()
        }

    @property
    def odometry_velocity(self) -> Velocity:
        """The velocity in base_link that odometry reports; 0 if it reports none."""
        wheels = self.robot.commanded if Fault.OPEN_LOOP_ODOMETRY in self.faults else self.robot.velocity
        return self.odometry.velocity(wheels) if self.settings.odometry.twist else STANDSTILL

    def observe(self, now: float | None = None) -> Observation:
        """Return the observation of a docking node that has received all topics.

        Args:
            now: The moment by the caller's clock, which its stamps will be of; None is simulated time.
        """
        now = self.time if now is None else now
        offset = now - self.time
        ranges, measured, odometry = self.ranges, self.measurement, self.track.latest
        camera = camera_mount(self.settings.marker.camera_yaw)
        markers = [
            MarkerDetection(one.odometry.compose(one.marker), one.at + offset, one.odometry.compose(camera))
            for one in self.sightings
        ]
        return Observation(
            now=now,
            battery=None if measured is None else _reading(measured[0], measured[1] + offset),
            odometry=None if odometry is None else replace(odometry, stamp=odometry.stamp + offset),
            marker=markers[-1] if markers else None,
            other_markers=tuple(markers[:-1]),
            scan=self._observe_scan(offset),
            joints={name: Joint(*wheel, now) for name, wheel in self.wheels.items()},
            infrared=None if ranges is None else replace(ranges[1], stamp=ranges[1].stamp + offset),
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

    def _wheel_ways(self, dt: float) -> tuple[float, float, float]:
        """Return what odometry takes the wheels to have turned, in m: the left one, the right one, and to the left."""
        robot = self.robot
        if Fault.OPEN_LOOP_ODOMETRY not in self.faults:
            return robot.left, robot.right, robot.side
        commanded = robot.commanded
        half = 0.5 * self.settings.robot.wheel_separation * commanded.angular_z
        return (commanded.linear_x - half) * dt, (commanded.linear_x + half) * dt, 0.0

    def _collide(self, *, driven: bool = True) -> None:
        self._collisions.resolve(self.robot, self.obstacles, self.time, driven=driven)

    def _random(self, part: str) -> Random:
        return Random(f"{self._seed} {part}")  # noqa: S311 - noise, not secrets

    def _feed(self, dt: float) -> None:
        """The charger, or the battery, gives what the robot needs."""
        powered = Fault.DEAD_CHARGER not in self.faults
        flickers, dirty = Fault.FLICKERING_CHARGE in self.faults, Fault.DIRTY_CONTACTS in self.faults
        connected = self._collisions.connected(self.time, flickers=flickers, dirty=dirty)
        self.battery.step(dt, self._power(dt), connected=connected, powered=powered)

    def _power(self, dt: float) -> float:
        settings, robot = self.settings, self.robot
        speed = 0.5 * (abs(robot.left) + abs(robot.right)) / dt
        stalled = settings.stall_power if robot.stalled else 0.0
        return settings.electronics_power + settings.driving_power * speed + stalled

    def _sense(self) -> None:
        """Each sensor measures when its time has come; what was measured arrives when its time has come."""
        now = self.time + 1e-9
        self._reckon()
        self._localization.step(now, JUMP if Fault.LOCALIZATION_JUMPS in self.faults else 0.0)
        if now >= self._picture_due:
            self._picture_due += 1.0 / self.settings.marker.rate
            self._take_picture()
        self._detect()
        if now >= self._ranges_due:
            self._ranges_due += 1.0 / self.settings.infrared.rate
            self._measure_ranges()
        if self.scanning and now >= self._scan_due:
            self._scan_due = self.time + 1.0 / self.settings.laser.rate
            distances = self._scanner.scan(self.robot.pose, self.dock, self.obstacles, self.settings.room)
            distances = self._frozen_scan.pass_on(distances, frozen=Fault.FROZEN_SCAN in self.faults)
            self.scan = LaserScan(distances, self.odometry.pose, self.time)
        if now >= self._measurement_due:
            self._measurement_due += 1.0 / self.settings.battery.battery_rate
            self._measure_battery()

    def _reckon(self) -> None:
        """Odometry of now is sent, that of earlier arrives."""
        settings, now = self.settings.odometry, self.time
        arrives_at = now + settings.delay
        stamp = (now if settings.honest_stamps else arrives_at) + settings.stamp_offset
        reading = Odometry(self.odometry.pose, self.odometry_velocity, arrives_at)
        faulty = REPEATING if Fault.REPEATED_ODOMETRY in self.faults else settings
        frozen = Fault.FROZEN_ODOMETRY in self.faults
        self._readings.send(self._repeater.pass_on(stamp, reading, now, faulty, frozen=frozen), arrives_at)
        for arrived in self._readings.arrived(now):
            self.reading = arrived
            self.track.add(*arrived)

    def _take_picture(self) -> None:
        if Fault.OCCLUDED_MARKER in self.faults:
            return
        settings, robot = self.settings.marker, self.robot.pose
        outliers = WRONG if Fault.WRONG_DETECTIONS in self.faults else 0.0
        room = self.settings.room
        hiding: tuple[Obstacle | Box, ...] = self.obstacles + (() if room is None else room.furniture)
        seen = [
            camera.detect(robot.relative_to(Pose(y=y)), self.time, (thing.seen_from(y) for thing in hiding), outliers)
            for camera, y in zip(self._cameras, self.dock.places, strict=True)
        ]
        if settings.second_y != 0.0:
            seen.append(self._second.detect(robot.relative_to(Pose(y=settings.second_y)), self.time))
        markers = self._detector_faults.pass_on(
            [marker for marker in seen if marker is not None],
            self.time,
            self.robot.velocity,
            frozen=Fault.FROZEN_CAMERA in self.faults,
            extrapolates=Fault.EXTRAPOLATING_CAMERA in self.faults,
        )
        if markers:
            lagging = Fault.LAGGING_DETECTIONS in self.faults
            arrives_at = self.time + settings.delay + (LAGGING if lagging else 0.0)
            honest = settings.honest_stamps and not lagging
            stamp = (self.time if honest else arrives_at) + settings.stamp_offset
            stamp += AHEAD if Fault.FUTURE_DETECTIONS in self.faults else 0.0
            self._detections.send((stamp, markers), arrives_at)

    def _detect(self) -> None:
        """Detections arrive, and are put where odometry says that the robot was."""
        for stamp, markers in self._detections.arrived(self.time):
            self.detections = tuple((stamp, marker) for marker in markers)
            try:
                odometry = self.track.at(stamp)
            except LookupError:
                continue
            at = min(odometry.stamp, self.time)
            self.sightings = tuple(Sighting(marker, odometry.pose, stamp, at) for marker in markers)

    def _measure_ranges(self) -> None:
        ranges = self._receivers.measure(
            self.robot.pose.relative_to(Pose(y=self.dock.nearest(self.robot.y))),
            self.time,
            hidden=Fault.HIDDEN_BEACON in self.faults,
            ghosts=GHOSTS if Fault.INFRARED_GHOSTS in self.faults else 0.0,
        )
        measured = InfraredReading(*ranges, 0.0)
        reading = self._frozen_ranges.pass_on(measured, frozen=Fault.FROZEN_BEACON in self.faults)
        self.ranges = self.time, replace(reading, stamp=self.track.arrival(self.time, self.time))

    def _measure_battery(self) -> None:
        if Fault.SILENT_BATTERY in self.faults:
            return
        measured = self.battery.measure()
        if Fault.PERCENTAGE_0_TO_100 in self.faults:
            measured = replace(measured, percentage=100.0 * measured.percentage)
        self.measurement = (measured, self.time)


def _reading(measured: BatteryMeasurement, at: float) -> BatteryReading:
    return BatteryReading(measured.status, at, measured, measured.percentage, measured.current)
