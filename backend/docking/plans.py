"""The plan that the parameters ask for."""

from docking.controllers.dock_pose import DockPosePlan
from docking.controllers.infrared import InfraredPlan
from docking.controllers.plan import Plan, Solo
from docking.controllers.rotate import Rotate
from docking.parameters import ControllerName, DockSettings


def make_plan(settings: DockSettings) -> Plan:
    """A new plan for a goal, by the parameter `controller`."""
    if settings.controller is ControllerName.DOCK_POSE:
        return DockPosePlan(
            settings.dock,
            settings.motion,
            search_speed=settings.search_speed,
            detection_timeout=settings.detection_timeout,
        )
    if settings.controller is ControllerName.INFRARED:
        return InfraredPlan(
            settings.dock,
            settings.motion,
            settings.receivers,
            search_speed=settings.search_speed,
            detection_timeout=settings.detection_timeout,
        )
    return Solo(Rotate(settings.rotate_speed))
