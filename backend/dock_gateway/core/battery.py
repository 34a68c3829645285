"""Checks the values of a battery state. Pure: a sensor_msgs/BatteryState as decoded JSON in, plain data out."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

# The settings that say what a robot's battery driver means, as alerts name them: keys of its table.
COUNTS_TO_100 = 'battery.percentage = "0-100"'
CHARGES_NEGATIVE = 'battery.charging_current = "negative"'


class PowerSupply(IntEnum):
    """sensor_msgs/BatteryState, power_supply_status."""

    UNKNOWN = 0
    CHARGING = 1
    DISCHARGING = 2
    NOT_CHARGING = 3
    FULL = 4


class Bounds(NamedTuple):
    """The least and the greatest value that can be right, and the unit."""

    low: float
    high: float
    unit: str

    @property
    def words(self) -> str:
        """The bounds, as a person reads them."""
        return f"{self.low:g} to {self.high:g} {self.unit}"


_TEMPERATURE = Bounds(-100.0, 150.0, "°C")
_CHARGE = Bounds(0.0, 100_000.0, "Ah")
# Wide enough for any robot: what lies beyond is another unit (mV, K), a number that stands for "unknown", or garbage.
BOUNDS: Mapping[str, Bounds] = {
    "voltage": Bounds(0.0, 1000.0, "V"),
    "current": Bounds(-1000.0, 1000.0, "A"),
    "temperature": _TEMPERATURE,
    "charge": _CHARGE,
    "capacity": _CHARGE,
    "design_capacity": _CHARGE,
}
CELL_BOUNDS: Mapping[str, Bounds] = {"cell_voltage": Bounds(0.0, 60.0, "V"), "cell_temperature": _TEMPERATURE}
# Rounding below 0, and the charge that real drivers give a battery that is more than full.
PERCENTAGE = Bounds(-0.001, 1.02, "")
# A percentage above this does not belong to a driver that counts to 1, however full its battery is.
SURELY_TO_100 = 2.0
STATUSES = frozenset(PowerSupply)


class Doubt(NamedTuple):
    """A value that cannot be right and is not used.

    Attributes:
        field: The field's path, such as `cell_voltage.0`.
        value: Its value; an infinity is a text, as JSON has no number for it.
        expected: The expected values.
        advice: A sentence that says what may help; may be empty.
        grace: Seconds for which it is normal, as while a driver starts.
    """

    field: str
    value: float | str
    expected: str
    advice: str = ""
    grace: float = 0.0

    @property
    def sentence(self) -> str:
        """The fault, and advice, if there is any."""
        value = f"{self.value:.10g}" if isinstance(self.value, int | float) else self.value
        return f"{self.field} is {value}, but should be {self.expected}.{self.advice and ' '}{self.advice}"

    def document(self) -> dict[str, Any]:
        """Return it as `GET /battery` shows it."""
        return {"field": self.field, "value": self.value, "expected": self.expected}


@dataclass(frozen=True)
class BatteryReading:
    """A battery state without the values that are not believed; None: not measured, or not believed.

    Attributes:
        power_supply: `power_supply_status`; UNKNOWN if it is not one that there is.
        percentage: 0 to 1.
        current: In A, positive into the battery.
        doubts: The values that are not believed, as they were last.
        named: Those that are worth an alert, as they were first, so that its text stays the same.
    """

    power_supply: int = PowerSupply.UNKNOWN
    percentage: float | None = None
    current: float | None = None
    doubts: tuple[Doubt, ...] = ()
    named: tuple[Doubt, ...] = ()


def fraction(state: Mapping[str, Any], *, counts_to_100: bool) -> float | None:
    """Return the charge of a state, 0 to 1; None if it is not measured or cannot be right."""
    value = state["percentage"]
    if value is None or isinstance(value, str) or _doubt_charge(state, counts_to_100=counts_to_100) is not None:
        return None
    return float(min(1.0, max(0.0, value / 100 if counts_to_100 else value)))


def measured(state: Mapping[str, Any], field: str) -> float | None:
    """Return the value of a field of `BOUNDS`; None if it is not measured or cannot be right."""
    value = state.get(field)
    return None if value is None or _outside(value, BOUNDS[field]) else float(value)


def doubts(state: Mapping[str, Any], *, counts_to_100: bool) -> Iterator[Doubt]:
    """Yield the values of a state that cannot be right, one of each field. The stamp is another matter.

    Args:
        state: A BatteryState as JSON. An infinity is a text, such as `inf`.
        counts_to_100: Whether its percentage is 0 to 100.
    """
    if (charge := _doubt_charge(state, counts_to_100=counts_to_100)) is not None:
        yield charge
    for field, bounds in BOUNDS.items():
        value = state.get(field)
        if value is not None and _outside(value, bounds):
            yield Doubt(field, value, bounds.words)
    for field, bounds in CELL_BOUNDS.items():
        for place, value in enumerate(state.get(field, ())):
            if value is not None and _outside(value, bounds):
                yield Doubt(f"{field}.{place}", value, bounds.words)
                break
    status = state["power_supply_status"]
    if status not in STATUSES:
        yield Doubt("power_supply_status", status, "0 (UNKNOWN) to 4 (FULL)")


def _doubt_charge(state: Mapping[str, Any], *, counts_to_100: bool) -> Doubt | None:
    value = state["percentage"]
    if value is None:
        return None
    if counts_to_100:
        expected, advice = f"0 to 100, as the robot's {COUNTS_TO_100} says", ""
    else:
        expected, advice = "0 to 1", f"If the driver counts to 100, set {COUNTS_TO_100} for the robot."
    if isinstance(value, str) or value < PERCENTAGE.low or (value / 100 if counts_to_100 else value) > PERCENTAGE.high:
        if not isinstance(value, str) and value < 0:
            advice = "A driver that does not know the charge should send NaN; check that it knows the battery."
        return Doubt("percentage", value, expected, advice)
    if value == 0 and state.get("voltage") == 0:
        return Doubt(
            "percentage", 0.0, "a measured charge; 0 with 0 V means that nothing has been measured yet", grace=10.0
        )
    return None


def doubt_unit(value: float) -> Doubt:
    """Return the doubt about a percentage below 1 of a driver that has counted to 100 before."""
    advice = f"The driver seems to count to 100: set {COUNTS_TO_100} for the robot."
    return Doubt("percentage", value, f"0 to 1, but it was above {SURELY_TO_100:g} before", advice)


def _outside(value: float | str, bounds: Bounds) -> bool:
    return isinstance(value, str) or not bounds.low <= value <= bounds.high


def infinities(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that are infinite or have such an item, which JSON cannot express, with texts instead."""
    found: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, float):
            if math.isinf(value):
                found[name] = str(value)
        elif any(map(math.isinf, value)):
            found[name] = [_text(item) for item in value]
    return found


def _text(item: float) -> float | str | None:
    if math.isnan(item):
        return None
    return str(item) if math.isinf(item) else item
