"""The plan that the parameters ask for."""

from docking.behaviors.rotate import Rotate
from docking.goal.plan import Plan, SingleStage
from docking.parameters import ControllerName, DockSettings
from docking.plans.dock_pose import DockPosePlan
from docking.plans.infrared import InfraredPlan


def make_plan(settings: DockSettings) -> Plan:
    """A new plan for a goal, by the parameter `controller`."""
    if settings.controller is ControllerName.DOCK_POSE:
        return DockPosePlan(
            settings.dock,
            settings.motion,
            settings.approach,
            search_speed=settings.search_speed,
            detection_timeout=settings.external_detection_timeout,
        )
    if settings.controller is ControllerName.INFRARED:
        return InfraredPlan(
            settings.dock,
            settings.motion,
            settings.approach,
            settings.receivers,
            search_speed=settings.search_speed,
            detection_timeout=settings.external_detection_timeout,
        )
    return SingleStage(Rotate(settings.rotate_speed))
