"""The drive of a robot to where it waits for a dock that another one has. Rules over plain data.

The step that docks it is running all the time: the drive is carried out in its place, as a step is, and then the dock
is asked for again. A drive that fails is not repeated: the robot waits where it is.
"""

from datetime import datetime

from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.moves import Facts
from dock_gateway.extensions.missions.step_entry import StepEntry, StepStatus
from dock_gateway.extensions.missions.step_kinds import NavigateStep, Waypoint

# Seconds that a drive may take: less than the dock is kept for a robot that does not ask.
DRIVES_WITHIN = 240.0


def drive(mission: MissionEntry, place: Waypoint, facts: Facts, now: datetime) -> MissionEntry | None:
    """Return the mission on its way to where its robot waits; None if it waits where it is.

    A robot that stands on a dock stays there, and so does one that has driven to the place already.
    """
    fails_at = mission.current.fails_at
    left = DRIVES_WITHIN if fails_at is None else min(DRIVES_WITHIN, (fails_at - now).total_seconds())
    if mission.wait_at == place or facts.docked or facts.charging or left < 1:
        return None
    step = StepEntry(navigate=NavigateStep(pose=place), timeout_s=left)
    return mission.but(drive=step, drives=mission.drives + 1, wait_at=place)


def ask_again(mission: MissionEntry) -> MissionEntry:
    """Return the mission without a drive that has not begun, or was stopped: the dock may be free by now.

    If it is not, the robot is sent where no other one waits by now.
    """
    if mission.drive is None or mission.drive.status is not StepStatus.WAITING:
        return mission
    return mission.but(drive=None, wait_at=None)
