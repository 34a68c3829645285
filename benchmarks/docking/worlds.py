"""The rows of the table that is measured in MuJoCo."""

from dataclasses import dataclass, replace
from random import Random

from benchmarks.docking.cases import CASES, CASES_BY_NAME, DOCK_POSE, Case
from docking.simulation.settings import Settings


@dataclass(frozen=True, slots=True)
class Base:
    """What differs between robots and floors.

    Attributes:
        mass: Of the body, in kg.
        friction: Of the floor with the wheels, as a coefficient.
        torque: Highest of each motor, in Nm.
        gain: Of the control of the wheels' speeds, in Nm per rad/s; there is no integral, so that a load slows them.
        spring_travel: How far the dock's pins must be pressed until a current flows, in m, of 2 cm that they give way.
        other_robot: Whether another robot stands on the dock, with its motors off.
    """

    mass: float = 5.0
    friction: float = 0.8
    torque: float = 0.5
    gain: float = 5.0
    spring_travel: float = 0.0
    other_robot: bool = False


def _late(settings: Settings, _random: Random) -> Settings:
    return replace(settings, command_delay=0.1)


OCCUPIED = "A dock that is occupied is none to dock at: the robot touches the other one and gives up, with the reason."
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
    "5 kg, dead zone 0.13 m/s": (Base(), CASES_BY_NAME["dead zone 0.13 m/s"]),
    "5 kg, dead zone 0.13 m/s, v_linear_min 0.15 m/s": (
        Base(),
        CASES_BY_NAME["dead zone 0.13 m/s, v_linear_min 0.15 m/s"],
    ),
    "5 kg, contacts on springs": (Base(spring_travel=0.013), CASES[0]),
    "5 kg, contacts on springs, final_push 3 cm": (
        Base(spring_travel=0.013),
        Case("pushed on", (DOCK_POSE,), final_push=0.03),
    ),
    "5 kg, another robot stands on the dock": (Base(other_robot=True), Case("occupied", (DOCK_POSE,), why=OCCUPIED)),
    "5 kg, camera freezes": (Base(), CASES_BY_NAME["camera freezes"]),
    "5 kg, camera freezes for 1 to 5 s": (Base(), CASES_BY_NAME["camera freezes for 1 to 5 s"]),
    "5 kg, no marker, pose off by 4 cm, up to 4°": (Base(), CASES_BY_NAME["no marker, pose off by 4 cm, up to 4°"]),
    "25 kg, weak control of the wheels": (
        Base(mass=25.0, torque=1.0, gain=0.5),
        Case("weak", (DOCK_POSE,), why=WEAK_WHEELS),
    ),
}
"""By name: the robot, and what is wrong with it."""
