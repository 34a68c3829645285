"""Parameters of what the robot does before an attempt is given up, and after the last one."""

from dataclasses import dataclass

from docking.core.parameter import number, switch


@dataclass(frozen=True, slots=True)
class RecoverySettings:
    """Corrective moves on the contacts, and the way back after the last attempt."""

    return_to_staging: bool = switch(
        True,
        "Whether the robot goes back to its staging pose after the last attempt has failed in front of the dock or on "
        "it, before the goal is aborted; not after a cancel or a stop. Not for rotate.",
    )
    max_corrections: int = number(
        2,
        0,
        10,
        "",
        "Maximum number of corrective moves of a goal, when the battery does not charge on the contacts: the robot "
        "backs by correction_distance, turns by correction_angle, to the left and to the right in turn, and presses "
        "again; 0: none. Not for rotate.",
    )
    correction_distance: float = number(0.05, 0.01, 0.2, "m", "Distance that a corrective move backs.")
    correction_angle: float = number(
        0.035, 0.0, 0.35, "rad", "Angle to either side that corrective moves turn by; 0: straight back and on again."
    )
    max_presses: int = number(
        20,
        0,
        20,
        "",
        "Maximum number of presses beside each other that feel for the contacts, instead of these moves, at docks with "
        "use_external_detection_pose false; 0: none.",
    )
    correction_timeout: float = number(10.0, 1.0, 60.0, "s", "Time limit for each corrective move.")
