"""Controllers by name: ours, and those of other packages."""

from collections.abc import Callable
from typing import Protocol

from docking.behaviors.rotate import Rotate
from docking.goal.plan import Plan, SingleStage
from docking.parameters import ControllerName, DockSettings
from docking.parameters.controller import load_controller
from docking.plans.dock_pose import DockPosePlan
from docking.plans.infrared import InfraredPlan


class PlanType(Protocol):
    """What an entry point of another package refers to: a class of plans, or anything else that makes them.

    Attributes:
        sensors: What its plans need of `odometry`, `marker`, `infrared` and `scan`.
    """

    sensors: frozenset[str]

    def __call__(self, settings: DockSettings) -> Plan:
        """A new plan for a goal."""


def _dock_pose(settings: DockSettings) -> Plan:
    return DockPosePlan(
        settings.dock,
        settings.motion,
        settings.approach,
        search_speed=settings.search_speed,
        detection_timeout=settings.external_detection_timeout,
    )


def _infrared(settings: DockSettings) -> Plan:
    return InfraredPlan(
        settings.dock,
        settings.motion,
        settings.approach,
        settings.receivers,
        search_speed=settings.search_speed,
        detection_timeout=settings.external_detection_timeout,
    )


def _rotate(settings: DockSettings) -> Plan:
    return SingleStage(Rotate(settings.rotate_speed))


OURS: dict[str, tuple[Callable[[DockSettings], Plan], frozenset[str]]] = {
    ControllerName.ROTATE: (_rotate, frozenset()),
    ControllerName.DOCK_POSE: (_dock_pose, frozenset({"odometry", "marker"})),
    ControllerName.INFRARED: (_infrared, frozenset({"odometry", "infrared"})),
}


def _find(controller: str) -> tuple[Callable[[DockSettings], Plan], frozenset[str]]:
    """What makes the plans, and the sensors that they need."""
    if controller in OURS:
        return OURS[controller]
    plan_type: PlanType = load_controller(controller)
    return plan_type, frozenset(plan_type.sensors)


def make_plan(settings: DockSettings) -> Plan:
    """A new plan for a goal, by the parameter `controller`."""
    return _find(settings.controller)[0](settings)


def sensors_of(controller: str) -> frozenset[str]:
    """What a controller needs: `odometry`, `marker`, `infrared`, `scan`."""
    return _find(controller)[1]
