"""The parameters of the node `dock_simulator`: names, types, units, ranges and defaults in one table."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from docking.core.geometry import Pose
from docking.parameters import FloatParameter, IntegerParameter, Parameter
from docking.simulation.simulation import Settings

DEFAULTS = Settings()


def _positive(name: str, default: float, maximum: float, unit: str, description: str) -> FloatParameter:
    return FloatParameter(name, default, 0.0, maximum, unit, description)


DOCK_SIMULATOR: tuple[Parameter, ...] = (
    FloatParameter(
        "real_time_factor",
        1.0,
        0.1,
        100.0,
        "",
        "Simulated seconds per second. Controllers expect 1, as they use the real clock.",
    ),
    _positive(
        "battery_resume_after",
        3.0,
        3600.0,
        "s",
        "Time without messages of other nodes on battery_status after which the simulated battery is published again.",
    ),
    IntegerParameter("seed", 0, 0, 2**31 - 1, "", "Seed of the random number generator."),
    FloatParameter("start_x", DEFAULTS.start.x, -20.0, 20.0, "m", "Start pose of the robot in world, x."),
    FloatParameter("start_y", DEFAULTS.start.y, -20.0, 20.0, "m", "Start pose, y."),
    FloatParameter("start_theta", DEFAULTS.start.theta, -3.15, 3.15, "rad", "Start pose, heading; 0 faces the dock."),
    _positive("battery_start", DEFAULTS.battery.start, 1.0, "", "Initial charge of the battery, 0 to 1."),
    _positive(
        "charge_current", DEFAULTS.battery.charge_current, 65.0, "A", "Charging current until the battery is full."
    ),
    _positive("linear_max", DEFAULTS.robot.linear_max, 5.0, "m/s", "Maximum linear velocity, forwards and backwards."),
    _positive(
        "angular_max", DEFAULTS.robot.angular_max, 10.0, "rad/s", "Maximum angular velocity, in both directions."
    ),
    _positive("linear_acceleration", DEFAULTS.robot.linear_acceleration, 20.0, "m/s²", "Maximum linear acceleration."),
    _positive(
        "angular_acceleration", DEFAULTS.robot.angular_acceleration, 50.0, "rad/s²", "Maximum angular acceleration."
    ),
    _positive(
        "cmd_vel_timeout",
        DEFAULTS.robot.watchdog,
        60.0,
        "s",
        "Simulated time without a message on cmd_vel after which the robot stops.",
    ),
    _positive("slip", DEFAULTS.robot.slip, 0.9, "", "Wheel slip, as a fraction of the wheel's rotation."),
    _positive(
        "slip_noise",
        DEFAULTS.robot.slip_noise,
        0.1,
        "m",
        "Standard deviation of a wheel's travel over 1 m.",
    ),
    _positive(
        "odometry_drift",
        DEFAULTS.odometry.drift,
        0.2,
        "",
        "Standard deviation of the error of each wheel's radius, as a fraction of the radius.",
    ),
    _positive(
        "marker_range", DEFAULTS.marker.range, 50.0, "m", "Maximum range at which the camera detects the marker."
    ),
    _positive(
        "marker_field_of_view", DEFAULTS.marker.field_of_view, 6.28, "rad", "Field of view of the camera, edge to edge."
    ),
    _positive(
        "marker_noise",
        DEFAULTS.marker.noise,
        1.0,
        "m",
        "Standard deviation of the marker's position, for each coordinate.",
    ),
    _positive(
        "marker_angle_noise", DEFAULTS.marker.angle_noise, 1.0, "rad", "Standard deviation of the marker's heading."
    ),
    _positive(
        "marker_drop_outs",
        DEFAULTS.marker.drop_outs,
        1.0,
        "",
        "Fraction of the camera images in which the marker is missed.",
    ),
    _positive("infrared_range", DEFAULTS.infrared.range, 50.0, "m", "Maximum range of the infrared receivers."),
    _positive(
        "infrared_noise",
        DEFAULTS.infrared.noise,
        1.0,
        "m",
        "Standard deviation of the measured distance to the beacon.",
    ),
)


@dataclass(frozen=True)
class SimulatorSettings:
    """The parameters of the node `dock_simulator`, as the program uses them."""

    real_time_factor: float
    battery_resume_after: float
    seed: int
    settings: Settings


def simulator_settings(values: Mapping[str, object]) -> SimulatorSettings:
    """The settings from a value for each parameter of `DOCK_SIMULATOR`."""
    numbers = {name: value for name, value in values.items() if isinstance(value, float)}
    settings = Settings(
        start=Pose(numbers["start_x"], numbers["start_y"], numbers["start_theta"]),
        robot=replace(
            DEFAULTS.robot,
            linear_max=numbers["linear_max"],
            angular_max=numbers["angular_max"],
            linear_acceleration=numbers["linear_acceleration"],
            angular_acceleration=numbers["angular_acceleration"],
            watchdog=numbers["cmd_vel_timeout"],
            slip=numbers["slip"],
            slip_noise=numbers["slip_noise"],
        ),
        odometry=replace(DEFAULTS.odometry, drift=numbers["odometry_drift"]),
        marker=replace(
            DEFAULTS.marker,
            range=numbers["marker_range"],
            field_of_view=numbers["marker_field_of_view"],
            noise=numbers["marker_noise"],
            angle_noise=numbers["marker_angle_noise"],
            drop_outs=numbers["marker_drop_outs"],
        ),
        infrared=replace(DEFAULTS.infrared, range=numbers["infrared_range"], noise=numbers["infrared_noise"]),
        battery=replace(DEFAULTS.battery, start=numbers["battery_start"], charge_current=numbers["charge_current"]),
    )
    return SimulatorSettings(
        real_time_factor=numbers["real_time_factor"],
        battery_resume_after=numbers["battery_resume_after"],
        seed=int(str(values["seed"])),
        settings=settings,
    )
