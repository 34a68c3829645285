"""The parameters of the node `dock_simulator`: those of the model, and three of the node."""

from dataclasses import dataclass

from docking.core.parameter import NodeSettings, group, number
from docking.simulation.simulation import Settings


@dataclass(frozen=True)
class SimulatorSettings(NodeSettings):
    """The parameters of the node."""

    real_time_factor: float = number(
        1.0,
        0.1,
        100.0,
        "",
        "Simulated seconds per second. Controllers expect 1, as they use the real clock.",
    )
    battery_resume_after: float = number(
        3.0,
        0.0,
        3600.0,
        "s",
        "Time without messages of other nodes on battery_status after which the simulated battery is published again.",
    )
    seed: int = number(0, 0, 2**31 - 1, "", "Seed of the random number generator.")
    settings: Settings = group(Settings)
