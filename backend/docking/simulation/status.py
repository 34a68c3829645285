"""The simulator's status."""

import json
from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.simulation.faults import Fault
from docking.simulation.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Status:
    """The state of the simulation, as published on /diagnostics.

    Attributes:
        faults: The active faults.
        contact: Whether robot and dock touch with their contacts.
        docked: Whether the charger gives power over them.
        halted: Whether a stop is latched.
        battery_publisher: `self`, or `other` while someone else publishes the battery's state.
        real_time_factor: Simulated seconds in each second, as measured.
        too_slow: Whether the machine is too slow for the simulation.
        places: Where a robot can be sent in the room, by name: base_link in world.
        commands: How many times the robot was placed, the simulator reset or a fault switched: what this shows follows.
    """

    faults: frozenset[Fault]
    contact: bool
    docked: bool
    halted: bool
    battery_publisher: str
    real_time_factor: float
    too_slow: bool
    places: tuple[tuple[str, Pose], ...]
    commands: int

    @property
    def message(self) -> str:
        """One line for a person."""
        if self.faults:
            return f"faults: {', '.join(sorted(self.faults))}"
        if self.halted:
            return "a stop is latched"
        if self.too_slow:
            return f"the machine is too slow: the simulation runs at {self.real_time_factor:.2g} of real time"
        return "docked" if self.docked else "not docked"

    def values(self) -> dict[str, str]:
        """The key values, in their order."""
        return {
            **{fault.value: _word(fault in self.faults) for fault in Fault},
            "contact": _word(self.contact),
            "docked": _word(self.docked),
            "halted": _word(self.halted),
            "battery_publisher": self.battery_publisher,
            "real_time_factor": f"{self.real_time_factor:g}",
            "too_slow": _word(self.too_slow),
            "places": json.dumps({name: (place.x, place.y, round(place.theta, 4)) for name, place in self.places}),
            "commands": str(self.commands),
        }


def status_of(
    simulation: Simulation, *, battery_publisher: str, real_time_factor: float, too_slow: bool, commands: int
) -> Status:
    """The status of a simulation and of the node around it."""
    return Status(
        faults=simulation.faults,
        contact=simulation.contact,
        docked=simulation.charging,
        halted=simulation.halted,
        battery_publisher=battery_publisher,
        real_time_factor=real_time_factor,
        too_slow=too_slow,
        places=() if simulation.settings.room is None else simulation.settings.room.places,
        commands=commands,
    )


def _word(value: bool) -> str:
    return "true" if value else "false"
