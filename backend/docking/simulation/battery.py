"""The robot's battery: a pack of cells in series, with what it gives, takes, heats and measures."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.battery import PowerSupplyStatus
from docking.core.parameter import number, switch
from docking.simulation.discharge import HHR650D, SECONDS_PER_HOUR, DischargeCurve


@dataclass(frozen=True, slots=True)
class BatterySettings:
    """Properties of the battery and its charger.

    Attributes:
        cells: In series.
        charge_current: At 6.5 A, an empty battery takes an hour.
        ambient: Temperature around, in °C.
        cooling: Heat that leaves for each degree above that, in W/K.
        spread: Standard deviation of what the voltage of a cell differs from the mean by, in V.
    """

    battery_start: float = number(0.24, 0.0, 1.0, "", "Initial charge of the battery, 0 to 1.")
    battery_reports_status: bool = switch(
        True, "Whether power_supply_status tells what the battery does; else it is always UNKNOWN (0)."
    )
    battery_rate: float = number(10.0, 0.1, 100.0, "Hz", "Battery messages per second.")
    battery_charges_negative: bool = switch(False, "Whether the current is negative while the battery charges.")
    cells: int = 7
    charge_current: float = number(6.5, 0.0, 65.0, "A", "Charging current until the battery is full.")
    ambient: float = 25.0
    cooling: float = 0.5
    spread: float = 0.004


@dataclass(frozen=True, slots=True)
class BatteryMeasurement:
    """The message of the battery's driver, in the fields and units of sensor_msgs/BatteryState.

    Attributes:
        voltage: At the poles, in V.
        temperature: In °C.
        current: In A, negative while discharging, unless the driver counts the other way.
        charge: That is left, in Ah.
        capacity: Of the full battery, in Ah.
        design_capacity: As printed on it, in Ah.
        percentage: 0…1.
        status: `power_supply_status`.
        cell_voltages: In V.
        cell_temperatures: In °C.
    """

    voltage: float
    temperature: float
    current: float
    charge: float
    capacity: float
    design_capacity: float
    percentage: float
    status: PowerSupplyStatus
    cell_voltages: tuple[float, ...]
    cell_temperatures: tuple[float, ...]


class BatteryPack:
    """NiMH cells in series. What goes in comes out again, but for the heat in the inner resistance.

    Attributes:
        current: In A, negative while discharging.
        status: `power_supply_status`: FULL and CHARGING with a charger that works, NOT_CHARGING with one that does not,
            else DISCHARGING.
        temperature: In °C.
        heat: That the inner resistance has made so far, in J.
    """

    __slots__ = (
        "_curve",
        "_heat_capacity",
        "_offsets",
        "_resistance",
        "_settings",
        "_taken",
        "current",
        "heat",
        "status",
        "temperature",
    )

    def __init__(self, settings: BatterySettings, random: Random) -> None:
        """Put the battery in.

        Args:
            settings: Its properties.
            random: Where the differences of its cells are drawn from.
        """
        cells = settings.cells
        self._settings = settings
        self._curve = DischargeCurve(HHR650D)
        self._resistance = cells * self._curve.resistance
        self._heat_capacity = cells * HHR650D.mass * 1000.0  # J/K; about 1000 J/(kg K) for a NiMH cell
        drawn = [random.gauss(0.0, settings.spread) for _ in range(cells)]
        mean = sum(drawn) / cells
        self._offsets = tuple(value - mean for value in drawn)
        self._taken = (1.0 - settings.battery_start) * self._curve.capacity
        self.current = 0.0
        self.status = PowerSupplyStatus.DISCHARGING
        self.temperature = settings.ambient
        self.heat = 0.0

    @property
    def percentage(self) -> float:
        """State of charge, 0…1."""
        return 1.0 - self._taken / self._curve.capacity

    @property
    def empty(self) -> bool:
        """Whether its protection has switched it off."""
        return self._taken >= self._curve.capacity

    @property
    def voltage(self) -> float:
        """At the poles, in V."""
        return self._settings.cells * self._curve.voltage(self._taken) + self._resistance * self.current

    @property
    def energy(self) -> float:
        """The energy that is left, in J."""
        return self._settings.cells * self._curve.energy(self._taken)

    def step(self, dt: float, power: float, *, connected: bool, powered: bool) -> None:
        """Give or take for `dt` seconds.

        Args:
            dt: In s, above 0.
            power: That the robot needs, in W. With a charger that works, it comes from there.
            connected: Whether the battery is at a charger.
            powered: Whether that charger works.
        """
        hours = dt / SECONDS_PER_HOUR
        if connected and powered:
            self.current = min(self._settings.charge_current, self._taken / hours)
            full = self._taken - self.current * hours <= 0.0
            self.status = PowerSupplyStatus.FULL if full else PowerSupplyStatus.CHARGING
        else:
            left = (self._curve.capacity - self._taken) / hours
            self.current = -min(self._discharge_current(power), left)
            self.status = PowerSupplyStatus.NOT_CHARGING if connected else PowerSupplyStatus.DISCHARGING
        self._taken = min(self._curve.capacity, max(0.0, self._taken - self.current * hours))
        heating = self._resistance * self.current * self.current
        self.heat += heating * dt
        cooling = self._settings.cooling * (self.temperature - self._settings.ambient)
        self.temperature += (heating - cooling) * dt / self._heat_capacity

    def _discharge_current(self, power: float) -> float:
        """The current at which the poles give a power: of two solutions the small one."""
        if self.empty:
            return 0.0
        voltage = self._settings.cells * self._curve.voltage(self._taken)
        root = voltage * voltage - 4.0 * self._resistance * power
        return (voltage - math.sqrt(max(0.0, root))) / (2.0 * self._resistance)

    def measure(self) -> BatteryMeasurement:
        """The current message of the battery's driver."""
        voltage, percentage = self.voltage, self.percentage
        mean = voltage / self._settings.cells
        return BatteryMeasurement(
            voltage=voltage,
            temperature=self.temperature,
            current=-self.current if self._settings.battery_charges_negative else self.current,
            charge=percentage * self._curve.capacity,
            capacity=self._curve.capacity,
            design_capacity=HHR650D.rated,
            percentage=percentage,
            status=self.status if self._settings.battery_reports_status else PowerSupplyStatus.UNKNOWN,
            cell_voltages=tuple(mean + offset for offset in self._offsets),
            cell_temperatures=(self.temperature,) * self._settings.cells,
        )
