"""Parameters that tell how the connection to the charger is detected."""

import enum
from dataclasses import dataclass

from docking.core.parameter import choice, number, switch


class ChargingSource(enum.StrEnum):
    """The source that tells whether the battery charges."""

    STATUS = "status"
    """`power_supply_status` is CHARGING or FULL."""
    CURRENT = "current"
    """The current that flows into the battery."""
    POSE = "pose"
    """The robot stands where it is docked."""
    NONE = "none"
    """The dock does not charge: the robot is docked where it stands as with `pose`, and no battery is needed."""


@dataclass(frozen=True, slots=True)
class ChargingSettings:
    """Parameters that tell whether the battery charges."""

    charging_source: ChargingSource = choice(
        ChargingSource.STATUS,
        "What tells that the battery charges: power_supply_status, the current, or the pose: the robot stands within "
        "docking_threshold of the docked pose at the end of its approach. With none the dock does not charge: the pose "
        "tells that the robot is docked, and the battery does not matter.",
    )
    charging_threshold: float = number(
        0.5, 0.0, 1000.0, "A", "Current into the battery above which it charges, with charging_source `current`."
    )
    charging_current_negative: bool = switch(
        False, "Whether the current is negative while the battery charges: for drivers that count the other way."
    )

    @property
    def by_pose(self) -> bool:
        """Whether the pose tells that the robot is docked."""
        return self.charging_source in {ChargingSource.POSE, ChargingSource.NONE}

    @property
    def charges(self) -> bool:
        """Whether the dock charges the battery at all."""
        return self.charging_source is not ChargingSource.NONE
