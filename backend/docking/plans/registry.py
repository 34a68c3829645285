"""Controllers by name: ours, and those of other packages."""

from typing import Protocol

from docking.behaviors.turns import Rotate
from docking.goal.plan import Plan, SingleStage
from docking.parameters import ControllerName, DockSettings
from docking.parameters.controller import load_controller
from docking.plans.dock_pose import DockPosePlan
from docking.plans.infrared import InfraredPlan
from docking.plans.located import LocatedPlan


class PlanType(Protocol):
    """The target of an entry point of another package: a class of plans, or anything else that makes them.

    Attributes:
        sensors: What its plans need of `odometry`, `marker`, `infrared` and `scan`.
    """

    sensors: frozenset[str]

    def __call__(self, settings: DockSettings) -> Plan:
        """A new plan for a goal."""


class RotatePlan(SingleStage):
    """The tutorial's: the robot turns on the spot."""

    sensors = frozenset[str]()

    def __init__(self, settings: DockSettings) -> None:
        super().__init__(Rotate(settings.rotate_speed))


OURS: dict[str, PlanType] = {
    ControllerName.ROTATE: RotatePlan,
    ControllerName.DOCK_POSE: DockPosePlan,
    ControllerName.INFRARED: InfraredPlan,
}


def _find(settings: DockSettings) -> PlanType:
    """Return what makes the plans."""
    if settings.by_localization:
        return LocatedPlan
    controller = settings.controller
    plan_type: PlanType = OURS[controller] if controller in OURS else load_controller(controller)
    return plan_type


def make_plan(settings: DockSettings) -> Plan:
    """A new plan for a goal, by the parameters `controller` and `use_external_detection_pose`."""
    return _find(settings)(settings)


def sensors_of(settings: DockSettings) -> frozenset[str]:
    """Return the sensors that the goals need: `odometry`, `marker`, `infrared`, `scan`, `localization`."""
    return frozenset(_find(settings).sensors)
