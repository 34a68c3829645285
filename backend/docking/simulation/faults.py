"""Faults that can be injected into the simulation."""

import enum

from docking.simulation.dock import DOCKED
from docking.simulation.obstacle import Obstacle
from docking.simulation.odometry import OdometrySettings

LATE = 0.3
"""How much later commands arrive with the fault `late_commands`, in s."""
LOST = 0.3
"""The part of the commands that do not arrive with the fault `lost_commands`."""
WORN = 0.1
"""How much smaller the right wheel is with the fault `worn_wheel`, as a fraction of its radius."""
WRONG = 1.0 / 3.0
"""The part of the detections that are wrong with the fault `wrong_detections`."""
GHOSTS = 0.1
"""The part of the infrared distances that are anything with the fault `infrared_ghosts`."""
AHEAD = 0.5
"""How far the camera's clock is ahead with the fault `future_detections`, in s."""
REPEATING = OdometrySettings(repeat_every=3.0, repeat_for=0.5)
"""Behavior of odometry with the fault `repeated_odometry`."""
JUMP = 0.2
"""How far the localization jumps at most with the fault `localization_jumps`, in m."""
LAGGING = 0.5
"""How late detections come with the fault `lagging_detections`, in s: their stamps are of their arrival."""
IN_THE_WAY = Obstacle(-0.55, 0.05, 0.08)
"""The obstacle in front of the dock with the fault `obstacle`."""
ON_THE_DOCK = Obstacle(DOCKED.x, DOCKED.y, 0.15, low=True)
"""The other robot with the fault `occupied_dock`."""


class Fault(enum.StrEnum):
    """Something that is broken for as long as it is switched on."""

    DEAD_CHARGER = "dead_charger"
    """The dock gives no power: contact without charge."""
    FLICKERING_CHARGE = "flickering_charge"
    """The contacts are dirty: the charging current is 0.4 s on, then 0.3 s off, forever."""
    DIRTY_CONTACTS = "dirty_contacts"
    """The contacts are dirty: no current flows before the robot has left them and pressed again."""
    OCCLUDED_MARKER = "occluded_marker"
    """Something stands before the marker: the camera does not see it."""
    STUCK_WHEEL = "stuck_wheel"
    """The left wheel does not turn, until the base switches its motors off to save them."""
    LATE_COMMANDS = "late_commands"
    """Commands take 0.3 s longer to get to the wheels."""
    LOST_COMMANDS = "lost_commands"
    """Three commands in ten do not arrive."""
    NO_COMMAND_TIMEOUT = "no_command_timeout"
    """The base goes on with its last command when no more commands come."""
    WORN_WHEEL = "worn_wheel"
    """The right wheel is 10 % smaller than commands and odometry take it for."""
    WRONG_DETECTIONS = "wrong_detections"
    """A third of the markers that the camera detects are somewhere else."""
    FUTURE_DETECTIONS = "future_detections"
    """The camera's clock is ahead by 0.5 s, and so are the stamps of detections."""
    LAGGING_DETECTIONS = "lagging_detections"
    """Detections come 0.5 s late, and their stamps are of their arrival."""
    FROZEN_CAMERA = "frozen_camera"
    """The detector repeats its last image, with new stamps."""
    EXTRAPOLATING_CAMERA = "extrapolating_camera"
    """The detector sees nothing any more, and lets the marker go on as it moved last."""
    REPEATED_ODOMETRY = "repeated_odometry"
    """For half a second in each three, odometry repeats its last message, with new stamps."""
    LOCALIZATION_JUMPS = "localization_jumps"
    """Every few seconds the localization jumps by 5 to 20 cm, for up to 3 s."""
    FROZEN_ODOMETRY = "frozen_odometry"
    """Odometry repeats its last message, with new stamps."""
    OPEN_LOOP_ODOMETRY = "open_loop_odometry"
    """Odometry reports what was commanded, whether the robot moves or not."""
    OBSTACLE = "obstacle"
    """Something stands in front of the dock."""
    OCCUPIED_DOCK = "occupied_dock"
    """Another robot stands on the dock; the camera sees the marker above it."""
    HIDDEN_BEACON = "hidden_beacon"
    """Something stands before the infrared beacon: no receiver sees it."""
    FROZEN_BEACON = "frozen_beacon"
    """The infrared receivers repeat their last reading, with new stamps."""
    FROZEN_SCAN = "frozen_scan"
    """The laser scanner repeats its last scan, with new stamps."""
    INFRARED_GHOSTS = "infrared_ghosts"
    """A tenth of the distances that the infrared receivers measure are anything."""
    SILENT_BATTERY = "silent_battery"
    """The battery measures nothing new, and nothing is published."""
    PERCENTAGE_0_TO_100 = "percentage_0_to_100"
    """The battery's driver takes percentage for a number between 0 and 100, as many in the wild do."""
