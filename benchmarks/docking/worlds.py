"""The rows of the table that is measured in MuJoCo."""

from dataclasses import dataclass, replace
from random import Random

from benchmarks.docking.cases import CASES, DOCK_POSE, Case
from docking.simulation.settings import Settings


@dataclass(frozen=True, slots=True)
class Base:
    """What differs between robots and floors.

    Attributes:
        mass: Of the body, in kg.
        friction: Of the floor with the wheels, as a coefficient.
        torque: Highest of each motor, in Nm.
        gain: Of the control of the wheels' speeds, in Nm per rad/s; there is no integral, so that a load slows them.
    """

    mass: float = 5.0
    friction: float = 0.8
    torque: float = 0.5
    gain: float = 5.0


def _late(settings: Settings, _random: Random) -> Settings:
    return replace(settings, command_delay=0.1)


WEAK_WHEELS = (
    "A base that drives on but turns much less than commanded is taken for blocked on the way to the staging pose."
    " Give such a base an integral in the control of its wheels."
)
WORLDS: dict[str, tuple[Base, Case]] = {
    "5 kg, friction 0.8": (Base(), CASES[0]),
    "5 kg, friction 0.1": (Base(friction=0.1), CASES[0]),
    "25 kg, commands 0.1 s late": (
        Base(mass=25.0, torque=1.0),
        Case("late", (DOCK_POSE,), _late),
    ),
    "25 kg, weak control of the wheels": (
        Base(mass=25.0, torque=1.0, gain=0.5),
        Case("weak", (DOCK_POSE,), why=WEAK_WHEELS),
    ),
}
"""By name: the robot, and what is wrong with it."""
