"""The parameters of the action servers. A new parameter is one more field here; see `core.parameter`."""

from docking.parameters.approach import ApproachSettings, Gains
from docking.parameters.charging import ChargingSettings, ChargingSource
from docking.parameters.collision import CollisionSettings, Outline
from docking.parameters.controller import ControllerName
from docking.parameters.detector import DetectorSettings
from docking.parameters.dock import Dock, DockDirection, DockType, Staging
from docking.parameters.dock_database import DockDatabase, DockEntry
from docking.parameters.dock_server import DockSettings
from docking.parameters.limits import BACKWARDS, MotionLimits
from docking.parameters.navigation import NavigationSettings, StagingGoal
from docking.parameters.receivers import Receivers
from docking.parameters.recovery import RecoverySettings
from docking.parameters.search import DockPlace, SearchSettings
from docking.parameters.server import GoalPolicy, ServerSettings, StampedCmdVel, read_topics
from docking.parameters.stall import StallSettings
from docking.parameters.timeouts import DockTimeouts, Timeouts, UndockTimeouts
from docking.parameters.undock_server import UndockSettings

__all__ = [
    "BACKWARDS",
    "ApproachSettings",
    "ChargingSettings",
    "ChargingSource",
    "CollisionSettings",
    "ControllerName",
    "DetectorSettings",
    "Dock",
    "DockDatabase",
    "DockDirection",
    "DockEntry",
    "DockPlace",
    "DockSettings",
    "DockTimeouts",
    "DockType",
    "Gains",
    "GoalPolicy",
    "MotionLimits",
    "NavigationSettings",
    "Outline",
    "Receivers",
    "RecoverySettings",
    "SearchSettings",
    "ServerSettings",
    "Staging",
    "StagingGoal",
    "StallSettings",
    "StampedCmdVel",
    "Timeouts",
    "UndockSettings",
    "UndockTimeouts",
    "read_topics",
]
