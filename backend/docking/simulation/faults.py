"""What can be made to go wrong in the simulation."""

import enum


class Fault(enum.StrEnum):
    """Something that is broken for as long as it is switched on."""

    DEAD_CHARGER = "dead_charger"
    """The dock gives no power: contact without charge."""
    OCCLUDED_MARKER = "occluded_marker"
    """Something stands before the marker: the camera does not see it."""
    STUCK_WHEEL = "stuck_wheel"
    """The left wheel does not turn, until the base switches its motors off to save them."""
    LATE_COMMANDS = "late_commands"
    """Commands take 0.3 s longer to get to the wheels."""
    WORN_WHEEL = "worn_wheel"
    """The right wheel is 10 % smaller than commands and odometry take it for."""
    WRONG_DETECTIONS = "wrong_detections"
    """A third of the markers that the camera detects are somewhere else."""
    OBSTACLE = "obstacle"
    """Something stands in front of the dock."""
    HIDDEN_BEACON = "hidden_beacon"
    """Something stands before the infrared beacon: no receiver sees it."""
    INFRARED_GHOSTS = "infrared_ghosts"
    """A tenth of the distances that the infrared receivers measure are anything."""
    SILENT_BATTERY = "silent_battery"
    """The battery measures nothing new, and nothing is published."""
    PERCENTAGE_0_TO_100 = "percentage_0_to_100"
    """The battery's driver takes percentage for a number between 0 and 100, as many in the wild do."""
